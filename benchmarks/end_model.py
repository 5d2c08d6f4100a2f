"""Training of the bundled end model: ``python -m benchmarks.end_model --out FILE``.

It learns from commands that imitate people with their right ends (``benchmarks/written``), without
plans and trees: which of the ends that are right is meant doesn't matter. In every third look at a
command the ends of some loads are given, so that it learns how those of several go together. The
encoder's last layers are trained further. ``--set`` names the sets to learn from, by default all
but those that stay held out, or that the choice among plans is fitted to. ``--without`` leaves out
sets, and ``--test`` measures on sets: the share of commands of which the most probable ends are
right. ``--start`` trains a model further: the bundled one learned from 139 sets without given ends,
and then in four passes from 151 with them. It needs ``pip install torch``.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from benchmarks.encoder_layers import EncoderLayers, as_array
from benchmarks.written_commands import CHOICE, HELD_OUT, SETS, records_of, state_of
from g3.actions.robot_state import State
from g3.geometry.plane import BoolArray, IntArray
from g3.inference.ends.described import FEATURES, Described, describe, things_of
from g3.inference.ends.end_model import (
    ELSEWHERE,
    END_TYPES,
    GROUND,
    HEADS,
    HELD,
    NEAR,
    NO_CARRIER,
    ON,
    ROBOT,
    SIDES,
    STANDS,
    STAYS,
    EndModel,
    ends_of,
    known_ends,
    robot_ends,
)
from g3.inference.ends.proposal import likely_ends
from g3.language.parsing.encoder import (
    NORM_EPSILON,
    Encoder,
    Float32Array,
    layer_arrays,
    with_last_layers,
)
from g3.language.parsing.encoder import State as InsideEncoder
from g3.language.parsing.sdc_parser import default_parser
from g3.language.parsing.words import cut
from g3.storage.atomic_file import write_bytes

WIDTH, LAYERS, DROPOUT = 144, 3, 0.3
ENCODER_LAYERS, ENCODER_DROPOUT, ENCODER_RATE = 2, 0.2, 5e-5
EPOCHS, BATCH, RATE, DECAY, WARM_UP = 15, 32, 1e-3, 0.05, 0.1
KNOWN = 1 / 3
"""Share of looks at a command in which some ends are given."""
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
OTHER_WAY = re.compile(r"(heading |at \S+ )(-?[\d.]+)")
"""Numbers of ends that change their sign where sides are exchanged."""
SIDE_END = re.compile(r"\b(left|right)-of ")
SIDE_OF = {"by": 0, "left-of": 1, "right-of": 2, "front-of": 3, "behind": 4, "between": 5}
"""Index of a side among `SIDES`, by the name of the end."""
NO_SIDE_SAID = -1
NOT_THERE = -1e9
"""Logarithm of the probability of what is not there."""


@dataclass(frozen=True, slots=True)
class Example:
    """A described command about t things, with the a ends that are right.

    Parameters
    ----------
    seen
        The command.
    inside
        It inside of the encoder, before the layers that are trained.
    loads
        Ends of each thing that are right, shape (a, t, 3 + 2 t); all are of what is no load.
    robots
        Ends of the robot that are right, shape (a, 7 + 2 t); all are where loads are handled.
    sides
        Side that each thing ends on, shape (a, t).
    known
        Ends that are given, by row.
    """

    seen: Described
    inside: InsideEncoder
    loads: BoolArray
    robots: BoolArray
    sides: IntArray
    known: Mapping[int, int] = field(default_factory=dict)

    def with_some_known(self, rng: np.random.Generator) -> Example:
        """Give some loads' ends, as one of the right outcomes has them, every third time."""
        rows = np.flatnonzero(self.seen.loads)
        if rng.random() > KNOWN or not rows.size:
            return self
        meant = self.loads[rng.integers(len(self.loads))]
        some = rng.choice(rows, rng.integers(1, len(rows) + 1), replace=False)
        known = {int(row): int(rng.choice(np.flatnonzero(meant[row]))) for row in some}
        kept = np.all([self.loads[:, row, end] for row, end in known.items()], axis=0)
        loads = self.loads[kept]
        loads[:, list(known)] = True
        return replace(
            self, loads=loads, robots=self.robots[kept], sides=self.sides[kept], known=known
        )


def examples_of(name: str, *, mirrored: bool = False) -> list[Example]:
    """Return the commands of a set; on request left and right are exchanged where that is clear."""
    encoder = default_parser().encoder_
    found = []
    for record in records_of(name):
        own = _mirrored(record) if mirrored else record
        state, words = state_of(own), cut(own["text"])
        seen = describe(words, state, encoder)
        (inside,) = encoder.states([words], len(encoder.layers) - ENCODER_LAYERS)
        ends = [_end(want, state, seen) for want in own["want"]]
        loads, robots, sides = map(np.stack, zip(*ends, strict=True))
        found.append(Example(seen, inside, loads, robots, sides))
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
    want = [
        SIDE_END.sub(
            lambda found: f"{other[found[1]]}-of ",
            OTHER_WAY.sub(lambda found: f"{found[1]}{-float(found[2]):g}", end),
        )
        for end in record["want"]
    ]
    return record | {"text": said, "things": things, "want": want}


def _end(want: str, state: State, seen: Described) -> tuple[BoolArray, BoolArray, IntArray]:
    """Return which ends of each thing and of the robot are wanted, and each thing's side."""
    ids = [thing.id for thing in things_of(state)]
    count = len(ids)
    loads = np.zeros((count, ON + 2 * count), dtype=bool)
    loads[:, STAYS] = True
    sides = np.full(count, NO_SIDE_SAID)
    robots = np.zeros(NEAR + 2 * count, dtype=bool)
    parts = [part.split() for part in want.split("&")]
    told = {name: tuple(map(float, named)) for name, *named in parts if name in ("at", "heading")}
    if told:
        turned = np.deg2rad(told.get("heading", (0.0,)))
        ends = robot_ends(np.array([*told.get("at", (0.0, 0.0)), *turned]), state)
        met = [end for end in ends if end < NEAR or "heading" in told]
        robots[met or [ELSEWHERE]] = True
    for name, *named in parts:
        if name == "near":
            robots[NEAR + ids.index(named[0])] = True
        elif name == "gone":
            robots[STANDS + 1 :] = True
        elif name not in (*told, "still") and not (name == "pick" and state.held == named[0]):
            own = loads[ids.index(named[0])]
            own[STAYS] = False
            marks = [ON + ids.index(mark) for mark in named[1:]]
            if name == "moved":
                own[STAYS + 1 :] = True
            elif name in ("pick", "ground"):
                own[HELD if name == "pick" else GROUND] = True
            else:
                own[[mark + count * (name != "on") for mark in marks]] = True
                sides[ids.index(named[0])] = SIDE_OF.get(name, NO_SIDE_SAID)
    loads[~seen.loads] = True
    if not robots.any() or not loads[seen.loads, STAYS].all():
        robots[:] = True
    return loads, robots, sides


class Block(nn.Module):
    """A layer: things attend to words, then to things, and are changed one by one."""

    def __init__(self) -> None:
        super().__init__()
        self.norms = nn.ModuleList(nn.LayerNorm(WIDTH, NORM_EPSILON) for _ in range(3))
        self.square = nn.ModuleList(nn.Linear(WIDTH, WIDTH) for _ in range(8))
        self.naming = nn.Parameter(torch.full((HEADS,), 2.0))
        self.pairs = nn.Linear(6, HEADS)
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

    def __init__(self, encoder: Encoder) -> None:
        super().__init__()
        width = encoder.width
        first = len(encoder.layers) - ENCODER_LAYERS
        self.encoder = EncoderLayers(
            encoder.layers[first:], encoder.norms[2 + 4 * first :], ENCODER_DROPOUT
        )
        sizes = {
            "words": (2 * width, WIDTH),
            "labels": (width, WIDTH),
            "features": (FEATURES, WIDTH),
            "hidden": (WIDTH, WIDTH),
            "end": (WIDTH, 3),
            "ask": (WIDTH, 2 * WIDTH),
            "told": (WIDTH, 2 * WIDTH),
            "kind": (WIDTH, 2),
            "decided": (END_TYPES, WIDTH),
            "side": (WIDTH, len(SIDES)),
            "robot_end": (WIDTH, NEAR),
            "robot_ask": (WIDTH, 2 * WIDTH),
            "robot_told": (WIDTH, 2 * WIDTH),
        }
        self.linear = nn.ModuleDict({name: nn.Linear(*size) for name, size in sizes.items()})
        self.norms = nn.ModuleList(nn.LayerNorm(WIDTH, NORM_EPSILON) for _ in range(2))
        self.robot = nn.Parameter(torch.zeros(WIDTH))
        self.layers = nn.ModuleList(Block() for _ in range(LAYERS))
        self.drop = nn.Dropout(DROPOUT)

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
        own = self.linear
        pieces = self.encoder(batch["pieces"], batch["inside"])
        words = torch.cat((batch["pool"] @ pieces, batch["words"]), 2)
        words = self.drop(self.norms[0](own["words"](words)))
        x = own["hidden"](functional.gelu(own["features"](batch["features"]), approximate="tanh"))
        x = x + own["labels"](batch["labels"]) + own["decided"](batch["decided"])
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
        met = torch.einsum(
            "bird,brd->bri",
            own["robot_told"](things).unflatten(2, (2, WIDTH)),
            own["robot_ask"](robot).unflatten(1, (2, WIDTH)),
        )
        met = (met / WIDTH**0.5).masked_fill(~there[:, None], -1e9).flatten(1)
        robots = torch.cat((own["robot_end"](robot), met), 1).log_softmax(1)
        return loads, robots, own["side"](things).log_softmax(2)

    def model(self, encoder: Encoder) -> EndModel:
        """Return the model, with an encoder whose last layers are those that were trained.

        Parameters
        ----------
        encoder
            The encoder before training.
        """
        layers = layer_arrays(self.encoder.arrays(), as_array(self.encoder.norms))
        own = with_last_layers(encoder, layers)
        weights = {n: v.astype(np.float16).astype(np.float32) for n, v in self._weights().items()}
        return EndModel(weights, own)

    def start_from(self, weights: Mapping[str, Float32Array]) -> None:
        """Take the weights of a model."""
        with torch.no_grad():
            for name, own in self._parameters_by_name().items():
                for parameter, value in zip(own, weights[name].reshape(len(own), -1), strict=True):
                    parameter.copy_(torch.from_numpy(value).view_as(parameter))

    def _weights(self) -> dict[str, Float32Array]:
        count = len(self.layers)
        stacks = {"norms": (2, 2), "layer_norms": (count, 3, 2), "square": (count, 8)}
        stacks |= dict.fromkeys(("naming", "inner", "outer", "pairs"), (count,))
        found = {}
        for name, own in self._parameters_by_name().items():
            stack = stacks.get(name.removesuffix("_bias"), ())
            found[name] = as_array(torch.stack(own)).reshape(*stack, *own[0].shape)
        return found

    def _parameters_by_name(self) -> dict[str, list[nn.Parameter]]:
        """Return the parameters that are stacked under each name of a model's weights."""
        norms = [norm for layer in self.layers for norm in layer.norms]
        found = {
            "robot": [self.robot],
            "norms": [own for norm in self.norms for own in (norm.weight, norm.bias)],
            "layer_norms": [own for norm in norms for own in (norm.weight, norm.bias)],
            "naming": [layer.naming for layer in self.layers],
        }
        for part, name in (("weight", ""), ("bias", "_bias")):
            squares = [own for layer in self.layers for own in layer.square]
            found[f"square{name}"] = [getattr(own, part) for own in squares]
            for key in ("inner", "outer", "pairs"):
                own = [getattr(layer, key) for layer in self.layers]
                found[f"{key}{name}"] = [getattr(linear, part) for linear in own]
            found |= {f"{key}{name}": [getattr(own, part)] for key, own in self.linear.items()}
        return found


def _batch(examples: Sequence[Example]) -> dict[str, Tensor]:
    n = max(len(e.seen.words) for e in examples)
    t = max(len(e.seen.labels) for e in examples)
    p = max(len(e.inside.owners) for e in examples)
    a = max(len(e.loads) for e in examples)
    width = examples[0].seen.labels.shape[1]
    shapes = {
        "words": (n, width),
        "pieces": (p, width),
        "pool": (n, p),
        "labels": (t, width),
        "features": (t, FEATURES),
        "naming": (t + 1, n),
        "decided": (t, END_TYPES),
        "pairs": (t + 1, t + 1, 6),
        "inside": (p,),
        "carriers": (t,),
        "spoken": (n,),
        "there": (t + 1,),
        "loads": (a, t, ON + 2 * t),
        "robots": (a, NEAR + 2 * t),
        "possible": (a,),
        "sides": (a, t, len(SIDES)),
    }
    logical = ("inside", "carriers", "spoken", "there", "loads", "robots", "possible")
    arrays = {
        name: np.zeros((len(examples), *shape), dtype=bool if name in logical else np.float32)
        for name, shape in shapes.items()
    }
    for i, example in enumerate(examples):
        seen, owners = example.seen, example.inside.owners
        words, things, ends = len(seen.words), len(seen.labels), len(example.loads)
        arrays["words"][i, :words] = seen.words[:, width:]
        arrays["pieces"][i, : len(owners)] = example.inside.vectors
        own = owners == np.arange(words)[:, None]
        arrays["pool"][i, :words, : len(owners)] = own / np.maximum(own.sum(1, keepdims=True), 1)
        for name in ("labels", "features", "carriers"):
            arrays[name][i, :things] = getattr(seen, name)
        arrays["naming"][i, 1 : things + 1, :words] = seen.naming
        decided, links = known_ends(example.known, things)
        arrays["decided"][i, :things] = decided
        arrays["pairs"][i, 1 : things + 1, 1 : things + 1] = np.dstack((seen.pairs, links))
        arrays["sides"][i, :ends, :things] = example.sides[..., None] == np.arange(len(SIDES))
        arrays["inside"][i, : len(owners)] = True
        arrays["spoken"][i, :words] = True
        arrays["there"][i, : things + 1] = True
        on, beside = example.loads[..., : ON + things], example.loads[..., ON + things :]
        arrays["loads"][i] = True
        arrays["loads"][i, :ends, :things] = False
        arrays["loads"][i, :ends, :things, : ON + things] = on
        arrays["loads"][i, :ends, :things, ON + t : ON + t + things] = beside
        arrays["robots"][i, :ends, : NEAR + things] = example.robots[:, : NEAR + things]
        arrays["robots"][i, :ends, NEAR + t : NEAR + t + things] = example.robots[
            :, NEAR + things :
        ]
        arrays["possible"][i, :ends] = True
    return {name: torch.from_numpy(array) for name, array in arrays.items()}


def _loss(loads: Tensor, robots: Tensor, sides: Tensor, batch: dict[str, Tensor]) -> Tensor:
    """Mean surprise at the right ends, whichever is meant."""
    right, robot = batch["loads"], batch["robots"]
    of_loads = loads[:, None].masked_fill(~right, NOT_THERE).logsumexp(3)
    of_loads = of_loads.masked_fill(right.all(3), 0).sum(2)
    of_robot = robots[:, None].masked_fill(~robot, NOT_THERE).logsumexp(2)
    of_sides = (sides[:, None] * batch["sides"]).sum((2, 3))
    told = (of_loads + of_robot + of_sides).masked_fill(~batch["possible"], NOT_THERE)
    return -told.logsumexp(1).clamp(min=-WORST).mean()


def train(
    examples: Sequence[tuple[Example, Example]],
    epochs: int = EPOCHS,
    seed: int = 0,
    start: EndModel | None = None,
) -> EndModel:
    """Train a model on commands, each as it is or mirrored, chosen again in each pass.

    One that is trained further learns at a third of the rate. The mean of its weights before and
    after is kept, which is better on texts of other kinds (Wortsman et al., 2022).
    """
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    encoder = default_parser().encoder_
    network = Network(encoder if start is None else start.encoder)
    if start is not None:
        network.start_from(start.weights)
    before = [own.detach().clone() for own in network.parameters()]
    most = np.array([RATE, ENCODER_RATE]) / (1 if start is None else 3)
    steps = epochs * -(-len(examples) // BATCH)
    inside = list(network.encoder.parameters())
    others = [own for name, own in network.named_parameters() if not name.startswith("encoder.")]
    optimiser = torch.optim.AdamW(
        [{"params": others, "lr": RATE}, {"params": inside, "lr": ENCODER_RATE}], weight_decay=DECAY
    )
    rates = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, most.tolist(), total_steps=steps, pct_start=WARM_UP
    )
    lengths = np.array([len(example.seen.words) for example, _ in examples])
    for epoch in range(epochs):
        order = np.argsort(lengths + 4 * rng.normal(size=len(examples)))
        parts = [order[i : i + BATCH] for i in range(0, len(order), BATCH)]
        rng.shuffle(parts)
        total = 0.0
        for part in parts:
            own = [examples[i][rng.integers(2)].with_some_known(rng) for i in part]
            batch = _batch(own)
            loads, robots, sides = network(batch)
            loss = _loss(loads, robots, sides, batch)
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            rates.step()
            total += float(loss.detach())
        if epoch % 5 == 4 or epoch == epochs - 1:
            print(f"pass {epoch + 1}: {total / len(parts):.3f}", flush=True)
    if start is not None:
        with torch.no_grad():
            for own, first in zip(network.parameters(), before, strict=True):
                own.lerp_(first, 0.5)
    return network.model(encoder)


def is_right(model: EndModel, record: dict[str, Any]) -> bool:
    """Check that the most probable ends of all loads are right."""
    state = state_of(record)
    ends = ends_of(record["text"], state, model)
    if ends is None:
        return False
    seen = describe(cut(record["text"]), state, model.encoder)
    likely = likely_ends(ends, state)
    rights = (_end(want, state, seen) for want in record["want"])
    return any(
        all((robots if row == ROBOT else loads[row])[end] for row, end in likely.items())
        for loads, robots, _ in rights
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.end_model", description=__doc__)
    of_sets: dict[str, Any] = {"action": "append", "choices": SETS, "metavar": "SET"}
    parser.add_argument("--set", dest="sets", **of_sets)
    parser.add_argument("--without", default=[], **of_sets)
    parser.add_argument("--test", default=[], **of_sets)
    parser.add_argument("--epochs", type=int, default=EPOCHS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", type=Path, help="file of a model to train further")
    parser.add_argument("--out", type=Path, help="file for the model")
    options = parser.parse_args()
    torch.set_num_threads(1)
    left_out = {*options.without, *HELD_OUT, *CHOICE}
    names = options.sets or [name for name in SETS if name not in left_out]
    examples = [
        both
        for name in names
        for both in zip(examples_of(name), examples_of(name, mirrored=True), strict=True)
    ]
    print(f"{len(examples)} commands of {len(names)} sets")
    start = EndModel.from_bytes(options.start.read_bytes()) if options.start else None
    model = train(examples, options.epochs, options.seed, start)
    for name in options.test:
        tested = records_of(name)
        print(f"{name:14} {sum(is_right(model, r) for r in tested)} of {len(tested)}", flush=True)
    if options.out:
        write_bytes(options.out, model.to_bytes())


if __name__ == "__main__":
    main()
