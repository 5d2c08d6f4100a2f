"""Training of the bundled encoder: ``python -m benchmarks.encoder --pretrained FOLDER``.

FOLDER has a small BERT in Hugging Face's form (``model.safetensors``, ``vocab.txt``), such as
MiniLM-L6-H384-uncased. Without it, the bundled encoder is trained further. It is trained, with the
choice of arcs, on the treebank and the lessons; on no other corpus, so that commands held out of
one are unseen. ``--out`` writes the two files that come with the package. ``--hold-out K`` leaves
out the people of every fourth writer, from K on, and measures on them. Without --pretrained, a
share of the weights before training is kept, which holds better where commands differ from those
learned (Wortsman et al., CVPR 2022). It needs
``pip install torch safetensors``.
"""

from __future__ import annotations

import argparse
import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from safetensors.torch import load_file
from torch import Tensor, nn
from torch.nn import functional

from benchmarks.encoder_layers import EncoderLayers, as_array
from benchmarks.treebank import FOLDER, Trees, score
from corpus_tools.importers.treebank import read_second_trees, read_treebank
from g3.language.parsing import encoder as encoding
from g3.language.parsing.arc_model import SLOPE, ArcModel, distance_rows
from g3.language.parsing.clause_arcs import read_arcs
from g3.language.parsing.encoder import MATRICES, NORM_EPSILON, Encoder, default_encoder
from g3.language.parsing.parser_file import to_bytes
from g3.language.parsing.perturbation import perturb
from g3.language.parsing.sdc_parser import DEFAULT, DEFAULT_L2, default_parser, parse_words
from g3.language.parsing.training.arc_training import new_model, with_labels
from g3.language.parsing.training.lessons import written_trees
from g3.language.parsing.words import cut
from g3.sdc.clauses import SDC, Span
from g3.storage.atomic_file import write_bytes

LAYER = {
    "query": "attention.self.query",
    "key": "attention.self.key",
    "value": "attention.self.value",
    "output": "attention.output.dense",
    "inner": "intermediate.dense",
    "outer": "output.dense",
}
LONGEST, DROPOUT, WIDER_DROPOUT = 256, 0.1, 0.25
RATE, ENCODER_RATE, BATCH, WARM_UP = 1e-3, 1e-4, 24, 100
HIDDEN, UNKNOWN = 0.1, 0.7
"""Share of the pieces of words that are hidden in training; of them, share that are unknown, where
the others are random ones."""
KEPT = 0.25
"""Share of the weights before training that is kept."""
RETYPED = 0.3
"""Share of the commands that are typed in another way, chosen again in each pass."""
KINDS = ("articles", "typos", "run-on")
JOINED = 0.35
"""Share of the commands that another one of the same person follows, chosen again in each pass."""
JOINTS = (". ", ". ", "\n", ", ", ", then ", " then ", " and then ", " and ", "; ", " ")
WRITERS = 4
_NOTHING: Any = (*[np.zeros((0, 0))] * 4, (), "")


class Example(NamedTuple):
    """A command to learn from, and who gave it."""

    text: str
    trees: Trees
    person: str = ""


class Net(nn.Module):
    """The encoder and the choice of arcs, as :mod:`g3.language.parsing` computes them."""

    def __init__(
        self, state: Mapping[str, Tensor], layers: int, kept: Sequence[int], start: ArcModel
    ):
        super().__init__()
        self.words = nn.Parameter(state["embeddings.word_embeddings.weight"][list(kept)])
        self.words.requires_grad_(requires_grad=False)
        places = state["embeddings.position_embeddings.weight"][:LONGEST]
        self.positions = nn.Parameter(places + state["embeddings.token_type_embeddings.weight"][0])
        names = ["embeddings.LayerNorm"]
        matrices = []
        for i in range(layers):
            at = f"encoder.layer.{i}"
            names += [f"{at}.attention.output.LayerNorm", f"{at}.output.LayerNorm"]
            matrices.append(
                {
                    name: (
                        as_array(state[f"{at}.{LAYER[name]}.weight"]),
                        as_array(state[f"{at}.{LAYER[name]}.bias"]),
                    )
                    for name in MATRICES
                }
            )
        norms = torch.stack(
            [state[f"{name}.{part}"] for name in names for part in ("weight", "bias")]
        )
        self.first_norm = nn.Parameter(norms[:2].clone())
        self.encoder = EncoderLayers(matrices, as_array(norms[2:]), DROPOUT)
        self.arcs = nn.ParameterDict(
            {
                f.name: nn.Parameter(torch.from_numpy(getattr(start, f.name)))
                for f in fields(ArcModel)
                if f.name != "labels"
            }
        )
        self.dropout, self.wider = nn.Dropout(DROPOUT), nn.Dropout(WIDER_DROPOUT)

    def encode(self, ids: Tensor, mask: Tensor, pool: Tensor) -> Tensor:
        """Return the vectors of words (commands, words, d) from those of their pieces."""
        x = self.words[ids] + self.positions[: ids.shape[1]]
        x = functional.layer_norm(x, x.shape[-1:], *self.first_norm, NORM_EPSILON)
        return torch.bmm(pool, self.encoder(self.dropout(x), mask))

    def loss(self, batch: Mapping[str, Tensor]) -> Tensor:
        """Return minus the mean log probability of the words' heads and labels."""
        with torch.autocast("cpu", torch.bfloat16):
            encoded = self.encode(batch["ids"], batch["pieces"], batch["pool"])
        x = self.wider(encoded.float())
        mask = batch["words"]
        count, n, _ = x.shape
        with_root = torch.cat([self.arcs["root"].expand(count, 1, -1), x], 1)
        dependents, heads, label_dependents, label_heads = (
            self.wider(functional.leaky_relu(y @ self.arcs[name][:-1] + self.arcs[name][-1], SLOPE))
            for y, name in (
                (x, "dependents"),
                (with_root, "heads"),
                (x, "label_dependents"),
                (with_root, "label_heads"),
            )
        )
        scores = _with_one(dependents) @ self.arcs["arcs"] @ heads.transpose(1, 2)
        distances = self.arcs["distances"][torch.from_numpy(distance_rows(n))]
        scores = torch.cat([scores[:, :, :1], scores[:, :, 1:] + distances], 2)
        possible = torch.cat([torch.ones(count, 1, dtype=torch.bool), mask], 1)
        scores = scores.masked_fill(~possible[:, None], -1e4)
        command, word = mask.nonzero(as_tuple=True)
        governors = _with_one(label_heads)[command, batch["heads"][mask]]
        named = torch.einsum(
            "mb,bkc,mc->mk",
            _with_one(label_dependents)[command, word],
            self.arcs["label_forms"],
            governors,
        )
        return functional.cross_entropy(scores[mask], batch["heads"][mask]) + (
            functional.cross_entropy(named, batch["labels"][mask])
        )


def _with_one(x: Tensor) -> Tensor:
    return torch.cat([x, torch.ones(*x.shape[:-1], 1)], -1)


class Trainer:
    """Batches of commands, as pieces of words and arcs."""

    def __init__(self, encoder: Encoder, labels: Sequence[str]) -> None:
        self.encoder = encoder
        self.labels = {label: i for i, label in enumerate(labels)}

    def batch(self, examples: Sequence[Example]) -> dict[str, Tensor]:
        """Return commands as padded tensors."""
        commands = [cut(example.text) for example in examples]
        pieces = [[self.encoder.pieces(form) for form in c.forms][:LONGEST] for c in commands]
        size = 2 + max(sum(map(len, of)) for of in pieces)
        count, n = len(examples), max(len(command.forms) for command in commands)
        ids = np.zeros((count, size), dtype=np.int64)
        mask, words = np.zeros((count, size), dtype=bool), np.zeros((count, n), dtype=bool)
        pool = np.zeros((count, n, size), dtype=np.float32)
        heads, labels = np.zeros((2, count, n), dtype=np.int64)
        begin, end = (self.encoder.vocabulary.index(name) for name in ("[CLS]", "[SEP]"))
        for row, (example, command, of) in enumerate(zip(examples, commands, pieces, strict=True)):
            flat = [begin, *(piece for word in of for piece in word), end]
            ids[row, : len(flat)], mask[row, : len(flat)], words[row, : len(of)] = flat, True, True
            at = 1
            for word, inside in enumerate(of):
                pool[row, word, at : at + len(inside)] = 1 / len(inside)
                at += len(inside)
            arcs = read_arcs(example.trees, command.spans)
            heads[row, : len(of)] = np.array(arcs.heads) + 1
            labels[row, : len(of)] = [self.labels.get(label, 0) for label in arcs.labels]
        arrays = {"ids": ids, "pieces": mask, "pool": pool, "words": words}
        arrays |= {"heads": heads, "labels": labels}
        return {name: torch.from_numpy(array) for name, array in arrays.items()}


def hidden(
    batch: Mapping[str, Tensor], vocabulary: Sequence[str], rng: np.random.Generator
) -> dict[str, Tensor]:
    """Return a batch with some pieces of words hidden."""
    ids = batch["ids"]
    chosen = torch.from_numpy(rng.random(ids.shape) < HIDDEN) & batch["pieces"]
    chosen[:, 0] = False
    unknown = torch.from_numpy(rng.random(ids.shape) < UNKNOWN)
    others = torch.from_numpy(rng.integers(0, len(vocabulary), ids.shape))
    others[unknown] = vocabulary.index("[UNK]")
    return {**batch, "ids": torch.where(chosen, others, ids)}


def retyped(example: Example, rng: np.random.Generator) -> Example:
    """Return a command as somebody else might type it, or as it is."""
    if rng.random() >= RETYPED:
        return example
    seed, kind = int(rng.integers(1 << 30)), KINDS[rng.integers(len(KINDS))]
    typed = perturb(example.text, kind, seed=seed, sdcs=example.trees)
    if not cut(typed.text).forms:
        return example
    return example._replace(text=typed.text, trees=typed.carry(example.trees))


def joined(example: Example, following: Example, rng: np.random.Generator) -> Example:
    """Return two commands as one text: people say several sentences at once."""
    text = example.text.rstrip()
    joint = " " if text[-1:] in ".!?" else JOINTS[rng.integers(len(JOINTS))]
    offset = len(text) + len(joint)
    trees = (*example.trees, *(_moved(sdc, offset) for sdc in following.trees))
    return Example(text + joint + following.text, trees, example.person)


def _moved(sdc: SDC, offset: int) -> SDC:
    words, relation = (
        tuple(Span(word.start + offset, word.text) for word in spans)
        for spans in (sdc.words, sdc.relation)
    )
    parts = (
        tuple(_moved(part, offset) for part in own)
        for own in (sdc.figure, sdc.landmark1, sdc.landmark2)
    )
    return SDC(sdc.type, words, relation, *parts)


def together(examples: Sequence[Example], rng: np.random.Generator) -> list[Example]:
    """Return the commands, some with one or two others of the same person behind them."""
    of: dict[str, list[Example]] = {}
    for example in examples:
        of.setdefault(example.person, []).append(example)
    found = []
    for example in examples:
        own = of[example.person]
        while rng.random() < JOINED and len(example.text) < LONGEST:
            example = joined(example, own[rng.integers(len(own))], rng)  # noqa: PLW2901
        found.append(example)
    return found


def train(net: Net, trainer: Trainer, examples: Sequence[Example], epochs: int) -> None:
    """Train the net in place."""
    rng = np.random.default_rng(0)
    heads = list(net.arcs.values())
    body = [net.positions, net.first_norm, *net.encoder.parameters()]
    optimiser = torch.optim.AdamW(
        [
            {"params": body, "base": ENCODER_RATE, "weight_decay": 0.01},
            {"params": heads, "base": RATE, "weight_decay": 1e-4},
        ]
    )
    total, step = epochs * -(-len(examples) // BATCH), 0
    begin = time.monotonic()
    for epoch in range(epochs):
        net.train()
        order = sorted(
            (retyped(example, rng) for example in together(examples, rng)),
            key=lambda example: len(example.text) + 20 * rng.random(),
        )
        batches = [order[at : at + BATCH] for at in range(0, len(order), BATCH)]
        losses = []
        for at in rng.permutation(len(batches)):
            for group in optimiser.param_groups:
                group["lr"] = group["base"] * min(1, step / WARM_UP) * max(0.02, 1 - step / total)
            batch = trainer.batch(batches[at])
            loss = net.loss(hidden(batch, trainer.encoder.vocabulary, rng))
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(net.parameters(), 5.0)
            optimiser.step()
            losses.append(float(loss.detach()))
            step += 1
        seconds = time.monotonic() - begin
        print(f"epoch {epoch + 1}: loss {np.mean(losses):.3f}, {seconds:.0f} s", flush=True)


def exported(net: Net, vocabulary: Sequence[str], labels: Sequence[str]) -> tuple[bytes, ArcModel]:
    """Return the encoder's file and the choice of arcs."""
    norms = as_array(torch.cat((net.first_norm, net.encoder.norms)))
    content = encoding.to_bytes(
        vocabulary, as_array(net.words), as_array(net.positions), norms, net.encoder.arrays()
    )
    return content, ArcModel(tuple(labels), **{k: as_array(v) for k, v in net.arcs.items()})


def kept_pieces(vocabulary: Sequence[str], texts: Sequence[str]) -> list[int]:
    """Return the pieces of words to keep: those of the commands, and those of English in ASCII.

    Long pieces inside of words are rare, and are left out unless a command has them.
    """
    full = Encoder(tuple(vocabulary), *_NOTHING)
    used = {i for text in texts for form in cut(text).forms for i in full.pieces(form)}
    special = ("[UNK]", "[CLS]", "[SEP]")

    def keep(i: int, piece: str) -> bool:
        plain = piece.removeprefix("##")
        if i in used or piece in special:
            return True
        return piece.isascii() and (len(plain) <= 3 or (plain.isalpha() and plain == piece))

    return [i for i, piece in enumerate(vocabulary) if keep(i, piece)]


def state_of(encoder: Encoder) -> dict[str, Tensor]:
    """Return an encoder's weights by the names that a BERT has in Hugging Face's form."""
    tables = {
        "word_embeddings": encoder.words * encoder.word_scales[:, None],
        "position_embeddings": encoder.positions,
        "token_type_embeddings": np.zeros((1, encoder.width), dtype=np.float32),
    }
    arrays = {f"embeddings.{name}.weight": array for name, array in tables.items()}
    names = ["embeddings.LayerNorm"]
    for i, layer in enumerate(encoder.layers):
        at = f"encoder.layer.{i}"
        names += [f"{at}.attention.output.LayerNorm", f"{at}.output.LayerNorm"]
        for name, (matrix, bias) in layer.items():
            arrays[f"{at}.{LAYER[name]}.weight"] = matrix
            arrays[f"{at}.{LAYER[name]}.bias"] = bias
    for name, (gain, shift) in zip(names, encoder.norms.reshape(-1, 2, encoder.width), strict=True):
        arrays[f"{name}.weight"], arrays[f"{name}.bias"] = gain, shift
    return {
        name: torch.from_numpy(np.array(array, dtype=np.float32)) for name, array in arrays.items()
    }


def main() -> None:
    """Train, measure and write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.encoder", description=__doc__)
    parser.add_argument("--pretrained", type=Path, help="folder of the model (default: bundled)")
    parser.add_argument("--layers", type=int, default=6, help="how many layers to keep")
    parser.add_argument("--epochs", type=int, default=10)
    parser.add_argument("--hold-out", type=int, choices=range(WRITERS), help="leave out writers")
    parser.add_argument("--out", type=Path, help="folder for the two files")
    options = parser.parse_args()
    torch.manual_seed(0)
    commands = {command.id: command for command in read_treebank(FOLDER)}
    writers = sorted({command.split_group for command in commands.values()})
    held = {name for i, name in enumerate(writers) if i % WRITERS == options.hold_out}
    taught = {k: c for k, c in commands.items() if c.split_group not in held}
    examples = [Example(c.text, c.trees, c.person) for c in taught.values()]
    examples += [
        Example(taught[name].text, trees, taught[name].person)
        for name, trees in read_second_trees(FOLDER).items()
        if name in taught
    ]
    examples += [Example(text, trees) for text, trees in written_trees()]
    labels = sorted({k for e in examples for k in read_arcs(e.trees, cut(e.text).spans).labels})
    if options.pretrained:
        vocabulary = (options.pretrained / "vocab.txt").read_text("utf-8").splitlines()
        kept = kept_pieces(vocabulary, [example.text for example in examples])
        state = load_file(options.pretrained / "model.safetensors")
        pieces = tuple(vocabulary[i] for i in kept)
        width = state["embeddings.word_embeddings.weight"].shape[1]
        start = new_model(labels, width, np.random.default_rng(0))
    else:
        bundled = default_encoder()
        pieces, state = bundled.vocabulary, state_of(bundled)
        kept = list(range(len(pieces)))
        start = with_labels(default_parser().arcs_, labels)
        labels = list(start.labels)
    net = Net(state, options.layers, kept, start)
    empty = Encoder(pieces, *_NOTHING)
    before = {name: value.clone() for name, value in net.state_dict().items()}
    train(net, Trainer(empty, labels), examples, options.epochs)
    if not options.pretrained:
        new = net.state_dict()
        net.load_state_dict({k: KEPT * before[k] + (1 - KEPT) * v for k, v in new.items()})
    content, arcs = exported(net, pieces, labels)
    print(f"{len(kept)} pieces, {len(content) / 1e6:.1f} MB")
    encoder = encoding.from_bytes(content)
    tested = [command for name, command in commands.items() if name not in taught]
    if tested:
        parses = parse_words(encoder, arcs, (cut(command.text) for command in tested))
        parsed = zip(parses, tested, strict=True)
        print(f"people held out: {score((p.sdcs, c.trees, c.text) for p, c in parsed)}")
    if options.out:
        write_bytes(options.out / encoding.FILE, content)
        digest = hashlib.sha256((FOLDER / "trees.jsonl").read_bytes()).hexdigest()
        card = {
            "corpora": {"treebank": f"sha256:{digest}"},
            "commands": len(examples),
            "l2": DEFAULT_L2,
        }
        write_bytes(options.out / DEFAULT, to_bytes(arcs, card, encoder))


if __name__ == "__main__":
    main()
