"""Training of the bundled end model: ``python -m benchmarks.end_model --out FILE``.

It learns from commands that imitate people with their right ends (``benchmarks/written``), without
plans and trees: which of the ends that are right is meant doesn't matter. ``--set`` names the sets
to learn from, by default all but those that stay held out, and ``--test`` sets to measure on: the
share of commands of which each load's most probable end is right. It needs ``pip install torch``.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from benchmarks.written_commands import HELD_OUT, SETS, records_of, state_of
from g3.actions.robot_state import State
from g3.inference.ends.described import FEATURES, Described, describe, things_of
from g3.inference.ends.end_model import (
    GROUND,
    HEADS,
    HELD,
    NO_CARRIER,
    ON,
    STAYS,
    EndModel,
)
from g3.language.parsing.encoder import NORM_EPSILON, Float32Array
from g3.language.parsing.sdc_parser import default_parser
from g3.language.parsing.words import cut
from g3.storage.atomic_file import write_bytes

WIDTH, LAYERS, DROPOUT = 144, 3, 0.3
EPOCHS, BATCH, RATE, DECAY, WARM_UP = 60, 32, 1e-3, 0.05, 0.1
WORST = 30.0
"""Nats: a command that makes no sense costs no more."""
SIDE = re.compile(r"left|right", re.IGNORECASE)
NO_SIDE = re.compile(
    r"(^|[.!?,:] *)right\b|\b(all|that's|is|are|was|be|has|have|what's|been|get|got) (left|right)\b"
    r"|\b(left|right) (over|there|here|now|away|then|so|off|after|up|beside|next|behind)\b"
    r"|\b(left|right) (where|as|lads)\b|alright|upright|leftover",
    re.IGNORECASE,
)
"""Texts in which a side may be something else: "right, then", "what is left"."""
ROBOT_STAYS, ROBOT_ELSEWHERE, ROBOT_NEAR = 0, 1, 2
"""Ends of the robot, learned beside those of loads, but not kept; those of being near each thing
follow from the last on."""
ANYWHERE = -1
"""End of a load that is moved, wherever it is put."""


class End(NamedTuple):
    """Right ends of the loads that are handled, by row, and of the robot if none is."""

    loads: dict[int, int]
    robot: int | None


@dataclass(frozen=True, slots=True)
class Example:
    """A described command with the ends that are right, any of them."""

    seen: Described
    ends: Sequence[End]


def examples_of(name: str, *, mirrored: bool = False) -> list[Example]:
    """Return the commands of a set; on request left and right are exchanged where that is clear."""
    encoder = default_parser().encoder_
    found = []
    for record in records_of(name):
        own = _mirrored(record) if mirrored else record
        state = state_of(own)
        ends = [_end(want, state) for want in own["want"]]
        found.append(Example(describe(cut(own["text"]), state, encoder), ends))
    return found


def _mirrored(record: dict[str, Any]) -> dict[str, Any]:
    """Exchange the sides of a yard and of its command, unless a word may mean something else."""
    text = record["text"]
    if NO_SIDE.search(text):
        return record
    other = {"left": "right", "Left": "Right", "LEFT": "RIGHT"}
    other |= {right: left for left, right in other.items()}
    things = {
        name: [kind, at and [at[0], -at[1]], -(heading or 0), deck]
        for name, thing in record["things"].items()
        for kind, at, heading, deck in [[*thing, None, None, None][:4]]
    }
    said = SIDE.sub(lambda found: other.get(found[0], found[0]), text)
    return record | {"text": said, "things": things}


def _end(want: str, state: State) -> End:
    ids = [thing.id for thing in things_of(state)]
    loads: dict[int, int] = {}
    robot = None
    for part in want.split("&"):
        name, *named = part.split()
        if name == "near":
            robot = ROBOT_NEAR + ids.index(named[0])
        elif name in ("heading", "gone"):
            robot = ROBOT_ELSEWHERE
        elif name == "at":
            near = math.hypot(*map(float, named)) < 1
            robot = ROBOT_STAYS if near else ROBOT_ELSEWHERE
        else:
            row = ids.index(named[0])
            ends = {
                "pick": STAYS if state.held == named[0] else HELD,
                "still": STAYS,
                "ground": GROUND,
                "moved": ANYWHERE,
            }
            on = ON + ids.index(named[1]) if len(named) > 1 else 0
            loads[row] = ends.get(name, on if name == "on" else on + len(ids))
    return End(loads, robot)


class Block(nn.Module):
    """A layer: things attend to words, then to things, and are changed one by one."""

    def __init__(self) -> None:
        super().__init__()
        self.norms = nn.ModuleList(nn.LayerNorm(WIDTH, NORM_EPSILON) for _ in range(3))
        self.square = nn.ModuleList(nn.Linear(WIDTH, WIDTH) for _ in range(8))
        self.naming = nn.Parameter(torch.full((HEADS,), 2.0))
        self.pairs = nn.Linear(4, HEADS)
        self.inner, self.outer = nn.Linear(WIDTH, 2 * WIDTH), nn.Linear(2 * WIDTH, WIDTH)
        self.drop = nn.Dropout(DROPOUT)

    def attend(self, first: int, x: Tensor, y: Tensor, bias: Tensor, there: Tensor) -> Tensor:
        """Attention of x to y, where it is there."""
        query, key, value = (
            linear(part).unflatten(2, (HEADS, -1)).transpose(1, 2)
            for linear, part in zip(self.square[first : first + 3], (x, y, y), strict=True)
        )
        scores = query @ key.transpose(2, 3) / query.shape[3] ** 0.5 + bias
        weights = self.drop(scores.masked_fill(~there[:, None, None], -1e9).softmax(3))
        mixed = (weights @ value).transpose(1, 2).flatten(2)
        return self.drop(self.square[first + 3](mixed))

    def forward(self, x: Tensor, words: Tensor, batch: dict[str, Tensor]) -> Tensor:
        naming = self.naming[:, None, None] * batch["naming"][:, None]
        x = x + self.attend(0, self.norms[0](x), words, naming, batch["spoken"])
        y, pairs = self.norms[1](x), self.pairs(batch["pairs"]).permute(0, 3, 1, 2)
        x = x + self.attend(4, y, y, pairs, batch["there"])
        inner = functional.gelu(self.inner(self.norms[2](x)), approximate="tanh")
        return x + self.drop(self.outer(self.drop(inner)))


class Network(nn.Module):
    """The same function as :class:`EndModel`, for batches and with slopes."""

    def __init__(self, width: int) -> None:
        super().__init__()
        sizes = {
            "words": (2 * width, WIDTH),
            "labels": (width, WIDTH),
            "features": (FEATURES, WIDTH),
            "hidden": (WIDTH, WIDTH),
            "end": (WIDTH, 3),
            "ask": (WIDTH, 2 * WIDTH),
            "told": (WIDTH, 2 * WIDTH),
            "kind": (WIDTH, 2),
            "robot_end": (WIDTH, 2),
            "robot_ask": (WIDTH, WIDTH),
            "robot_told": (WIDTH, WIDTH),
        }
        self.linear = nn.ModuleDict({name: nn.Linear(*size) for name, size in sizes.items()})
        self.norms = nn.ModuleList(nn.LayerNorm(WIDTH, NORM_EPSILON) for _ in range(2))
        self.robot = nn.Parameter(torch.zeros(WIDTH))
        self.layers = nn.ModuleList(Block() for _ in range(LAYERS))
        self.drop = nn.Dropout(DROPOUT)

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, Tensor]:
        own = self.linear
        words = self.drop(self.norms[0](own["words"](batch["words"])))
        x = own["hidden"](functional.gelu(own["features"](batch["features"]), approximate="tanh"))
        x = x + own["labels"](batch["labels"])
        x = torch.cat((self.robot.expand(len(x), 1, -1), x), 1)
        for layer in self.layers:
            x = layer(x, words, batch)
        x = self.norms[1](x)
        robot, things, there = x[:, 0], x[:, 1:], batch["there"][:, 1:]
        ask, told = (own[name](things).unflatten(2, (2, WIDTH)) for name in ("ask", "told"))
        at = torch.einsum("bird,bjrd->brij", ask, told) / WIDTH**0.5
        at = at + own["kind"](things).transpose(1, 2)[..., None]
        itself = torch.eye(things.shape[1], dtype=torch.bool)
        at = at.masked_fill(~there[:, None, None] | itself, -1e9)
        on = at[:, 0] - NO_CARRIER * ~batch["carriers"][:, None]
        loads = torch.cat((own["end"](things), on, at[:, 1]), 2).log_softmax(2)
        near = (own["robot_told"](things) @ own["robot_ask"](robot)[..., None])[..., 0]
        near = (near / WIDTH**0.5).masked_fill(~there, -1e9)
        return loads, torch.cat((own["robot_end"](robot), near), 1).log_softmax(1)

    def weights(self) -> dict[str, Float32Array]:
        """Return the weights as :class:`EndModel` has them."""

        def stacked(parts: Sequence[Tensor]) -> Float32Array:
            result: Float32Array = torch.stack(list(parts)).detach().numpy()
            return result

        found = {"robot": self.robot.detach().numpy()}
        found["norms"] = np.stack([stacked((n.weight, n.bias)) for n in self.norms])
        found["layer_norms"] = np.stack(
            [[stacked((n.weight, n.bias)) for n in layer.norms] for layer in self.layers]
        )
        found["naming"] = stacked([layer.naming for layer in self.layers])
        for part, name in (("weight", ""), ("bias", "_bias")):
            squares = [[getattr(own, part) for own in layer.square] for layer in self.layers]
            found[f"square{name}"] = np.stack([stacked(own) for own in squares])
            for key in ("inner", "outer", "pairs"):
                own = [getattr(getattr(layer, key), part) for layer in self.layers]
                found[f"{key}{name}"] = stacked(own)
            for key, linear in self.linear.items():
                if key.startswith("robot_"):
                    continue
                found[f"{key}{name}"] = getattr(linear, part).detach().numpy()
        return found


def _batch(examples: Sequence[Example]) -> dict[str, Tensor]:
    n = max(len(e.seen.words) for e in examples)
    t = max(len(e.seen.labels) for e in examples)
    first = examples[0].seen
    shapes = {
        "words": (n, first.words.shape[1]),
        "labels": (t, first.labels.shape[1]),
        "features": (t, FEATURES),
        "naming": (t + 1, n),
        "pairs": (t + 1, t + 1, 4),
        "carriers": (t,),
        "spoken": (n,),
        "there": (t + 1,),
    }
    logical = ("carriers", "spoken", "there")
    arrays = {
        name: np.zeros((len(examples), *shape), dtype=bool if name in logical else np.float32)
        for name, shape in shapes.items()
    }
    for i, example in enumerate(examples):
        seen, own = example.seen, (len(example.seen.words), len(example.seen.labels))
        arrays["words"][i, : own[0]] = seen.words
        for name in ("labels", "features", "carriers"):
            arrays[name][i, : own[1]] = getattr(seen, name)
        arrays["naming"][i, 1 : own[1] + 1, : own[0]] = seen.naming
        arrays["pairs"][i, 1 : own[1] + 1, 1 : own[1] + 1] = seen.pairs
        arrays["spoken"][i, : own[0]] = True
        arrays["there"][i, : own[1] + 1] = True
    return {name: torch.from_numpy(array) for name, array in arrays.items()}


def _loss(loads: Tensor, robots: Tensor, examples: Sequence[Example]) -> Tensor:
    """Mean surprise at the right ends, however many there are."""
    padding = (loads.shape[2] - ON) // 2
    costs = []
    for own, robot, example in zip(loads, robots, examples, strict=True):
        shift = padding - len(example.seen.labels)
        told = []
        for end in example.ends:
            total = own.new_zeros(())
            for row in np.flatnonzero(example.seen.loads).tolist():
                kind = end.loads.get(row, STAYS)
                if kind == ANYWHERE:
                    total = total + torch.log1p(1e-6 - own[row, STAYS].exp())
                else:
                    beside = kind >= ON + len(example.seen.labels)
                    total = total + own[row, kind + shift * beside]
            if not end.loads and end.robot is not None:
                total = total + robot[end.robot]
            told.append(total)
        costs.append(-torch.logsumexp(torch.stack(told), 0).clamp(min=-WORST))
    return torch.stack(costs).mean()


def train(
    examples: Sequence[tuple[Example, Example]], epochs: int = EPOCHS, seed: int = 0
) -> EndModel:
    """Train a model on commands, each as it is or mirrored, chosen again in each pass."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = Network(examples[0][0].seen.labels.shape[1])
    steps = epochs * -(-len(examples) // BATCH)
    optimiser = torch.optim.AdamW(network.parameters(), RATE, weight_decay=DECAY)
    rates = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, RATE, total_steps=steps, pct_start=WARM_UP
    )
    lengths = np.array([len(example.seen.words) for example, _ in examples])
    for epoch in range(epochs):
        order = np.argsort(lengths + 4 * rng.normal(size=len(examples)))
        parts = [order[i : i + BATCH] for i in range(0, len(order), BATCH)]
        rng.shuffle(parts)
        total = 0.0
        for part in parts:
            own = [examples[i][rng.integers(2)] for i in part]
            loads, robots = network(_batch(own))
            loss = _loss(loads, robots, own)
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            rates.step()
            total += float(loss.detach())
        if epoch % 10 == 9:
            print(f"pass {epoch + 1}: {total / len(parts):.3f}", flush=True)
    return EndModel(
        {n: v.astype(np.float16).astype(np.float32) for n, v in network.weights().items()}
    )


def is_right(model: EndModel, example: Example) -> bool:
    """Check that the most probable ends of all loads are right."""
    ends = model.ends(example.seen)
    likely = {row: int(ends.loads[row].argmax()) for row in ends.rows}
    moved = {row: kind for row, kind in likely.items() if kind != STAYS}
    right = [
        {row: kind for row, kind in end.loads.items() if kind != STAYS} for end in example.ends
    ]
    return moved in right


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.end_model", description=__doc__)
    parser.add_argument("--set", action="append", choices=SETS, dest="sets")
    parser.add_argument("--test", action="append", choices=SETS, default=[])
    parser.add_argument("--epochs", type=int, default=EPOCHS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="file for the model")
    options = parser.parse_args()
    torch.set_num_threads(1)
    names = options.sets or [name for name in SETS if name not in HELD_OUT]
    examples = [
        both
        for name in names
        for both in zip(examples_of(name), examples_of(name, mirrored=True), strict=True)
    ]
    print(f"{len(examples)} commands of {len(names)} sets")
    model = train(examples, options.epochs, options.seed)
    for name in options.test:
        tested = examples_of(name)
        print(f"{name:14} {sum(is_right(model, e) for e in tested)} of {len(tested)}", flush=True)
    if options.out:
        write_bytes(options.out, model.to_bytes())


if __name__ == "__main__":
    main()
