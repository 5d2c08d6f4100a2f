"""Vectors of words in their commands, by a small transformer (Devlin et al., 2019) in NumPy.

Its weights began as those of MiniLM-L6-H384-uncased (Wang et al., 2020; Apache License 2.0) and
were trained further on ``datasets/treebank`` (``python -m benchmarks.encoder``). The file holds
each row of a matrix as 8-bit integers with a scale.
"""

from __future__ import annotations

import hashlib
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from importlib import resources
from itertools import islice
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from g3.errors import ModelError
from g3.language.parsing.one_thread import one_thread
from g3.language.parsing.words import Words
from g3.short_repr import short_repr
from g3.storage.array_file import Array, Field, read_arrays, write_arrays

Float32Array: TypeAlias = npt.NDArray[np.float32]
FILE = "encoder.npz"
HEADS = 12
"""Attention heads."""
MATRICES = ("query", "key", "value", "output", "inner", "outer")
"""Matrices of a layer; each has a bias."""
BATCH = 64
"""Commands that are encoded at once."""
RECENT = 64
"""Commands of which the vectors after the shared layers are kept, at least."""
LAST = 2
"""Layers that encoders made from another one may have as their own."""
MOST_PIECES = 6
"""Pieces of one word; the rest is left out."""
_LONGEST_PIECE = 30
NORM_EPSILON = 1e-12
GELU_SCALE, GELU_CUBIC = np.float32(np.sqrt(2 / np.pi)), np.float32(0.044715)
"""Of the approximation of GELU by the hyperbolic tangent (Hendrycks and Gimpel, 2016)."""
_PARTS = re.compile(r"[^\W_]+|[^\w\s]|_")
LAYER_FIELDS = {
    "norms": Field("<f4", dimensions=2, finite=True),
    "biases": Field("<f4", dimensions=2, finite=True),
    "square": Field("|i1", dimensions=3),
    "square_scales": Field("<f4", dimensions=2, finite=True),
    "wide": Field("|i1", dimensions=3),
    "wide_scales": Field("<f4", dimensions=2, finite=True),
}
"""Arrays of layers in a file."""
_FIELDS = {
    "vocabulary": Field("|u1"),
    "words": Field("|i1", dimensions=2),
    "word_scales": Field("<f4", finite=True),
    "positions": Field("<f2", dimensions=2, finite=True),
    **LAYER_FIELDS,
}

Layer: TypeAlias = Mapping[str, tuple[Float32Array, Float32Array]]
"""The `MATRICES` of a layer (out, in) with their biases (out,)."""


class State(NamedTuple):
    """A command inside of the encoder.

    Parameters
    ----------
    vectors
        Those of its pieces of words, shape (pieces, d).
    owners
        The word of each piece; -1 for the marks of its beginning and end.
    """

    vectors: Float32Array
    owners: npt.NDArray[np.intp]


@short_repr
@dataclass(frozen=True, eq=False)
class Encoder:
    """A transformer's weights; d is its width and p the number of its pieces of words.

    Parameters
    ----------
    vocabulary
        The pieces of words; those that go on with a word begin with ``##``.
    words, word_scales
        Their vectors as integers (p, d), and the scale of each row (p,).
    positions
        Vectors of places in a command, shape (longest, d).
    norms
        Gains and shifts of the layers' normalisations (2 + 4 layers, d), those of the input first.
    layers
        For each layer its `MATRICES` (out, in) with their biases (out,).
    digest
        Digest of its file, by which what was trained with it knows it again.
    changed
        How many of the last layers aren't those of that file.
    recent
        Commands after the layers that all encoders made from that file share, by their words.
    """

    vocabulary: tuple[str, ...]
    words: npt.NDArray[np.int8]
    word_scales: Float32Array
    positions: Float32Array
    norms: Float32Array
    layers: tuple[Layer, ...]
    digest: str
    changed: int = 0
    recent: dict[tuple[str, ...], State] = field(default_factory=dict, repr=False)

    @property
    def width(self) -> int:
        """Length of a word's vector."""
        return int(self.words.shape[1])

    @cached_property
    def _ids(self) -> dict[str, int]:
        return {piece: i for i, piece in enumerate(self.vocabulary)}

    @cached_property
    def _pieces_of(self) -> dict[str, tuple[int, ...]]:
        return {}

    def pieces(self, form: str) -> tuple[int, ...]:
        """Return the pieces of a word, the longest first from its beginning (WordPiece)."""
        found = self._pieces_of.get(form)
        if found is None:
            found = self._pieces(form)
            if len(self._pieces_of) < 1 << 16:
                self._pieces_of[form] = found
        return found

    def meaning(self, forms: Sequence[str]) -> Float32Array:
        """Return the mean of the vectors of words' pieces, without their context, shape (d,)."""
        rows = [piece for form in forms for piece in self.pieces(form)]
        mean: Float32Array = (self.words[rows] * self.word_scales[rows, None]).mean(axis=0)
        return mean

    def _pieces(self, form: str) -> tuple[int, ...]:
        plain = "".join(
            c for c in unicodedata.normalize("NFD", form) if not unicodedata.combining(c)
        )
        ids: list[int] = []
        for part in _PARTS.findall(plain):
            at, inside = 0, []
            while at < len(part):
                before = "##" if at else ""
                ends = range(min(len(part), at + _LONGEST_PIECE), at, -1)
                end = next((e for e in ends if before + part[at:e] in self._ids), 0)
                if not end:
                    inside = [self._ids["[UNK]"]]
                    break
                inside.append(self._ids[before + part[at:end]])
                at = end
            ids += inside
        return tuple(ids[:MOST_PIECES]) or (self._ids["[UNK]"],)

    def encode_all(self, commands: Iterable[Words]) -> Iterator[Float32Array]:
        """Yield the vectors of each command's words, shape (n, d); `BATCH` are encoded at once.

        Words beyond the longest command that the encoder knows have the vector 0. The last commands
        are kept as they are after the shared layers, since several models ask for one.
        """
        waiting = iter(commands)
        shared = max(0, len(self.layers) - max(LAST, self.changed))
        while batch := list(islice(waiting, BATCH)):
            below = self._below(batch, shared)
            ends = np.cumsum([len(state.vectors) for state in below]).tolist()
            with one_thread():
                vectors = self._through(np.vstack([s.vectors for s in below]), ends, shared)
            for command, state, own in zip(batch, below, np.split(vectors, ends[:-1]), strict=True):
                yield _means(own, state.owners, len(command.forms))

    def _below(self, batch: Sequence[Words], layers: int) -> list[State]:
        """Return commands after the first layers; those that others have, too, are kept."""
        if self.changed > LAST:
            return self.states(batch, layers)
        kept = ((command.forms, self.recent.get(command.forms)) for command in batch)
        found = {forms: state for forms, state in kept if state is not None}
        new = [command for command in batch if command.forms not in found]
        found |= dict(
            zip((command.forms for command in new), self.states(new, layers), strict=True)
        )
        if len(self.recent) > RECENT:
            self.recent.clear()
        self.recent.update(found)
        return [found[command.forms] for command in batch]

    def all_states(self, commands: Iterable[Words], layers: int | None = None) -> Iterator[State]:
        """Yield what :meth:`states` returns of each command; `BATCH` are encoded at once."""
        waiting = iter(commands)
        while batch := list(islice(waiting, BATCH)):
            yield from self.states(batch, layers)

    def states(self, commands: Sequence[Words], layers: int | None = None) -> list[State]:
        """Return the vectors of each command's pieces of words after some layers; None for all."""
        rows: list[int] = []
        places: list[int] = []
        ends: list[int] = []
        owners: list[list[int]] = []
        for command in commands:
            pieces = [self._ids["[CLS]"]]
            owner = [-1]
            for i, form in enumerate(command.forms):
                piece_ids = self.pieces(form)
                if len(pieces) + len(piece_ids) >= len(self.positions):
                    break
                pieces += piece_ids
                owner += [i] * len(piece_ids)
            rows += [*pieces, self._ids["[SEP]"]]
            owners.append([*owner, -1])
            places += range(len(pieces) + 1)
            ends.append(len(rows))
        if not rows:
            return []
        x = self.words[rows].astype(np.float32) * self.word_scales[rows, None]
        x = normalised(x + self.positions[places], *self.norms[:2])
        with one_thread():
            vectors = self._through(x, ends, 0, layers)
        return [
            State(vectors[start:end], np.array(owner))
            for start, end, owner in zip([0, *ends], ends, owners, strict=False)
        ]

    def _through(
        self, x: Float32Array, ends: Sequence[int], first: int, last: int | None = None
    ) -> Float32Array:
        """Return vectors of pieces after layers; those of one command end where the next begin."""
        for number, layer in enumerate(self.layers[first:last], first):
            before, after = self.norms[2 + 4 * number :][:2], self.norms[4 + 4 * number :][:2]
            query, key, value = (linear(x, layer[name]) for name in MATRICES[:3])
            mixed = np.empty_like(x)
            for start, end in zip([0, *ends], ends, strict=False):
                mixed[start:end] = attend(query[start:end], key[start:end], value[start:end], HEADS)
            x = normalised(x + linear(mixed, layer["output"]), *before)
            x = normalised(x + linear(gelu(linear(x, layer["inner"])), layer["outer"]), *after)
        return x


def linear(x: Float32Array, weights: tuple[Float32Array, Float32Array]) -> Float32Array:
    """Multiply rows by a matrix (out, in), and add a bias (out,)."""
    matrix, bias = weights
    result: Float32Array = x @ matrix.T
    result += bias
    return result


def attend(
    query: Float32Array,
    key: Float32Array,
    value: Float32Array,
    heads: int,
    bias: Float32Array | None = None,
) -> Float32Array:
    """Attention of n rows to m rows, in several heads (Vaswani et al., 2017).

    Parameters
    ----------
    query
        Queries, shape (n, d).
    key, value
        Keys and values, shape (m, d).
    heads
        Number of heads; it divides d.
    bias
        Added to the scores, shape (heads, n, m).

    Returns
    -------
    ndarray
        Mixed values, shape (n, d).
    """
    n, d = query.shape
    q, k, v = (x.reshape(len(x), heads, d // heads).transpose(1, 0, 2) for x in (query, key, value))
    scores = q @ k.transpose(0, 2, 1) / np.float32(np.sqrt(d // heads))
    if bias is not None:
        scores += bias
    scores -= scores.max(axis=2, keepdims=True)
    np.exp(scores, out=scores)
    scores /= scores.sum(axis=2, keepdims=True)
    mixed: Float32Array = (scores @ v).transpose(1, 0, 2).reshape(n, d)
    return mixed


def normalised(x: Float32Array, gain: Float32Array, shift: Float32Array) -> Float32Array:
    """Give rows the mean 0 and the variance 1, then a gain and a shift (Ba et al., 2016)."""
    x = x - x.mean(axis=1, keepdims=True)
    scale = np.sqrt(np.square(x).mean(axis=1, keepdims=True) + np.float32(NORM_EPSILON))
    result: Float32Array = x / scale * gain + shift
    return result


def gelu(x: Float32Array) -> Float32Array:
    """Gaussian error linear unit, by its approximation with tanh (Hendrycks and Gimpel, 2016)."""
    inner = GELU_SCALE * (x + GELU_CUBIC * x * x * x)
    np.tanh(inner, out=inner)
    inner += 1
    inner *= x
    inner *= np.float32(0.5)
    result: Float32Array = inner
    return result


def _means(vectors: Float32Array, owner: npt.NDArray[np.intp], n: int) -> Float32Array:
    """Mean of the pieces of each of n words."""
    total = np.zeros((n, vectors.shape[1]), dtype=np.float32)
    of_words = owner >= 0
    np.add.at(total, owner[of_words], vectors[of_words])
    count = np.bincount(owner[of_words], minlength=n)
    total /= np.maximum(count, 1)[:, None].astype(np.float32)
    return total


# Files


def quantised(matrix: npt.ArrayLike | Sequence[Array]) -> tuple[npt.NDArray[np.int8], Float32Array]:
    """Return the rows of a matrix as 8-bit integers, and the scale of each row."""
    values = np.asarray(matrix, dtype=np.float32)
    parts, powers = np.frexp(np.maximum(np.abs(values).max(axis=-1), 1e-8) / 127)
    scales = np.ldexp(np.rint(parts * 4096) / 4096, powers)  # so that 127 times it is exact
    return np.rint(values / scales[..., None]).astype(np.int8), scales.astype(np.float32)


def layer_arrays(layers: Sequence[Layer], norms: npt.ArrayLike) -> dict[str, Array]:
    """Return layers as the arrays of a file, with the normalisations that go with them."""
    square = [np.asarray(layer[name][0]) for layer in layers for name in MATRICES[:4]]
    wide = [np.asarray(layer["inner"][0]) for layer in layers]
    wide += [np.asarray(layer["outer"][0]).T for layer in layers]
    square_integers, square_scales = quantised(square)
    wide_integers, wide_scales = quantised(wide)
    return {
        "norms": np.asarray(norms, dtype=np.float32),
        "biases": np.stack(
            [np.concatenate([np.ravel(layer[name][1]) for name in MATRICES]) for layer in layers]
        ).astype(np.float32),
        "square": square_integers,
        "square_scales": square_scales,
        "wide": wide_integers,
        "wide_scales": wide_scales,
    }


def layers_from(arrays: Mapping[str, Array]) -> tuple[Layer, ...]:
    """Return the layers that arrays of a file hold; ValueError or IndexError for other shapes."""
    count = len(arrays["biases"])
    square = arrays["square"] * arrays["square_scales"][..., None]
    wide = arrays["wide"] * arrays["wide_scales"][..., None]
    layers = []
    for i in range(count):
        matrices = [
            *square[4 * i : 4 * i + 4],
            wide[i],
            np.ascontiguousarray(wide[count + i].T),
        ]
        sizes = [len(matrix) for matrix in matrices]
        biases = np.split(arrays["biases"][i], np.cumsum(sizes)[:-1])
        layers.append(dict(zip(MATRICES, zip(matrices, biases, strict=True), strict=True)))
    return tuple(layers)


def with_last_layers(encoder: Encoder, arrays: Mapping[str, Array]) -> Encoder:
    """Return an encoder with other last layers, from the arrays of a file.

    Raises
    ------
    ValueError
        If they don't fit.
    """
    layers = layers_from(arrays)
    kept = len(encoder.layers) - len(layers)
    norms = encoder.norms.copy()
    if kept < 0 or arrays["norms"].shape != norms[2 + 4 * kept :].shape:
        raise ValueError("there are layers of another size")
    norms[2 + 4 * kept :] = arrays["norms"]
    for new, old in zip(layers, encoder.layers[kept:], strict=True):
        if any(new[name][0].shape != old[name][0].shape for name in MATRICES):
            raise ValueError("there are layers of another size")
    changed = max(len(layers), encoder.changed)
    return replace(encoder, layers=(*encoder.layers[:kept], *layers), norms=norms, changed=changed)


def to_bytes(
    vocabulary: Sequence[str],
    words: npt.ArrayLike,
    positions: npt.ArrayLike,
    norms: npt.ArrayLike,
    layers: Sequence[Layer],
) -> bytes:
    """Write an encoder's weights; the parameters are those of :class:`Encoder`."""
    integers, scales = quantised(words)
    arrays: dict[str, Array] = {
        "vocabulary": np.frombuffer("\n".join(vocabulary).encode(), dtype=np.uint8),
        "words": integers,
        "word_scales": scales,
        "positions": np.asarray(positions, dtype=np.float16),
        **layer_arrays(layers, norms),
    }
    return write_arrays(arrays, sealed=True)


def from_bytes(content: bytes, *, where: str = FILE) -> Encoder:
    """Read what :func:`to_bytes` wrote.

    Raises
    ------
    ModelError
        If it is damaged.
    """
    fix = "install the package again"
    arrays = read_arrays(content, _FIELDS, where=where, fix=fix, error=ModelError)
    try:
        layers = layers_from(arrays)
        vocabulary = tuple(arrays["vocabulary"].tobytes().decode().split("\n"))
        if len(vocabulary) != len(arrays["words"]) or arrays["words"].shape[1] % HEADS:
            raise ValueError("the vocabulary has another size")
    except (ValueError, IndexError) as error:
        raise ModelError(f"the encoder can't be read: {error}", where=where, fix=fix) from error
    return Encoder(
        vocabulary,
        arrays["words"],
        arrays["word_scales"],
        arrays["positions"].astype(np.float32),
        arrays["norms"],
        layers,
        f"sha256:{hashlib.sha256(content).hexdigest()}",
    )


@lru_cache(maxsize=1)
def default_encoder() -> Encoder:
    """Return the bundled encoder, read once.

    Raises
    ------
    ModelError
        If it is damaged.
    """
    return from_bytes((resources.files("g3.language.parsing") / FILE).read_bytes())
