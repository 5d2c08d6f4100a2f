"""Counts of words that tag the same pictures, over any list of tags per image.

The paper had the tags of millions of Flickr images (section 3.3). Here the list may be of any
length: it is read as a stream, twice, in memory that doesn't grow with it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from urllib.parse import unquote_plus

import numpy as np
import numpy.typing as npt
from scipy import sparse

from g3.errors import ModelError
from g3.groundings import FloatArray
from g3.language.lexicon.field_words import normalise
from g3.short_repr import short_repr
from g3.storage.array_file import Array, Field, read_arrays, write_arrays

MAX_TAGS_PER_IMAGE = 100
"""More are not a description; the pairs of a line grow with the square of it."""

_FIELDS = {
    "tags": Field("|u1"),
    "first": Field("<u4"),
    "second": Field("<u4"),
    "count": Field("<u4"),
    "images": Field("<i8"),
}
_LINES_AT_ONCE = 50_000
_BUCKET = 1_000_000


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class TagTable:
    """Counts of tags and of pairs of tags.

    Parameters
    ----------
    tags
        Stems of v tags, sorted.
    together
        In how many images two tags occur, and on the diagonal a tag by itself; symmetric,
        shape (v, v).
    images
        Number of images.
    """

    tags: tuple[str, ...]
    together: sparse.csr_array
    images: int

    def conditional(self, words: Iterable[str], given: Iterable[str]) -> FloatArray:
        """P(word | given) over images, 0 for what is no tag; shape (words, given)."""
        counts, _, alone = self._counts(words, given)
        return counts / np.maximum(alone, 1)

    def npmi(self, words: Iterable[str], others: Iterable[str]) -> FloatArray:
        """Normalised pointwise mutual information, negative as 0; shape (words, others).

        1 for tags that never occur without each other, 0 for independent ones and for
        what is no tag (Bouma, 2009).
        """
        counts, first, second = self._counts(words, others)
        seen = counts > 0
        both = np.where(seen, counts, 1) / max(self.images, 1)
        chance = np.where(seen, first[:, None] * second, 1) / max(self.images, 1) ** 2
        certain = both >= 1
        scale = np.where(certain, 1.0, -np.log(np.where(certain, 0.5, both)))
        # Tags that always come together come out a rounding error below 1.
        value = np.where(certain, 1.0, np.log(both / chance) / scale).round(12)
        result: FloatArray = np.where(seen, np.clip(value, 0, 1), 0.0)
        return result

    def _counts(
        self, words: Iterable[str], others: Iterable[str]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Images with both, with the word, and with the other; 0 for what is no tag."""
        rows, columns = self._index(words), self._index(others)
        alone = np.append(self.together.diagonal(), 0).astype(float)
        both = np.zeros((len(rows), len(columns)))
        i, j = np.flatnonzero(rows >= 0), np.flatnonzero(columns >= 0)
        if len(i) and len(j):
            both[np.ix_(i, j)] = self.together[rows[i]][:, columns[j]].toarray()
        return both, alone[rows], alone[columns]

    def _index(self, words: Iterable[str]) -> npt.NDArray[np.intp]:
        row = {tag: i for i, tag in enumerate(self.tags)}
        return np.array([row.get(normalise(word), -1) for word in words], dtype=np.intp)


def read_tags(line: str) -> frozenset[str]:
    """The stems of an image's tags, which commas, tabs or else spaces separate.

    >>> sorted(read_tags("Old+Truck,tires, flatbed"))
    ['flatb', 'old truck', 'tire']
    """
    separator = next((s for s in (",", "\t") if s in line), None)
    tags = (normalise(unquote_plus(tag).strip()) for tag in line.split(separator))
    return frozenset(islice((tag for tag in tags if tag), MAX_TAGS_PER_IMAGE))


def frequent_tags(
    images: Iterable[frozenset[str]], limit: int, *, bucket: int = _BUCKET
) -> tuple[str, ...]:
    """The most frequent tags, sorted (lossy counting; Manku and Motwani, 2002).

    Parameters
    ----------
    images
        The tags of each image.
    limit
        How many tags to return.
    bucket
        After so many tags, those as rare as one in a bucket are forgotten; a count is
        too small by at most one in a bucket. No tag is forgotten of fewer than this.
    """
    counts: dict[str, int] = {}
    forgotten_at: dict[str, int] = {}
    seen, buckets = 0, 0
    for tags in images:
        for tag in sorted(tags):
            if tag not in counts:
                forgotten_at[tag] = buckets
            counts[tag] = counts.get(tag, 0) + 1
        seen += len(tags)
        if seen >= (buckets + 1) * bucket:
            buckets = seen // bucket
            rare = [tag for tag, n in counts.items() if n + forgotten_at[tag] <= buckets]
            for tag in rare:
                del counts[tag], forgotten_at[tag]
    ranked = sorted(counts, key=lambda tag: (-counts[tag], tag))
    return tuple(sorted(ranked[:limit]))


def count_together(images: Iterable[frozenset[str]], tags: tuple[str, ...]) -> TagTable:
    """Count in how many images each two of some tags occur.

    Parameters
    ----------
    images
        The tags of each image.
    tags
        The tags to count, sorted; the counts take 4 bytes for each pair of them at most.
    """
    column = {tag: i for i, tag in enumerate(tags)}
    total = np.zeros((len(tags), len(tags)), dtype=np.uint32)
    number = 0
    for part in _parts(images):
        known = [[column[tag] for tag in image if tag in column] for image in part]
        offsets = np.concatenate(([0], np.cumsum([len(row) for row in known])))
        flat = np.array([i for row in known for i in row], dtype=np.intp)
        ones = np.ones(len(flat), dtype=np.uint32)
        which = sparse.csr_array((ones, flat, offsets), shape=(len(part), len(tags)))
        product = sparse.coo_array(which.T @ which)
        total[product.row, product.col] += product.data
        number += len(part)
    return TagTable(tags, sparse.csr_array(total), number)


def count_list(lines: Sequence[str]) -> TagTable:
    """Count all tags of a list that is small enough to hold; a line after # is a comment."""
    images = [read_tags(line) for line in lines if line.strip() and not line.startswith("#")]
    return count_together(images, tuple(sorted({tag for image in images for tag in image})))


def table_to_bytes(table: TagTable) -> bytes:
    """A tag table as the content of an .npz file; the same table gives the same bytes."""
    upper = sparse.coo_array(sparse.triu(table.together))
    arrays: dict[str, Array] = {
        "tags": np.frombuffer("\n".join(table.tags).encode(), dtype=np.uint8),
        "first": upper.row.astype(np.uint32),
        "second": upper.col.astype(np.uint32),
        "count": upper.data.astype(np.uint32),
        "images": np.array([table.images], dtype=np.int64),
    }
    return write_arrays(arrays, sealed=True)


def table_from_bytes(content: bytes, *, where: str = "", fix: str = "") -> TagTable:
    """Read what :func:`table_to_bytes` gives.

    Parameters
    ----------
    where, fix
        What to call it in an error, and what to do about it.

    Raises
    ------
    ModelError
        If it is something else, or damaged.
    """
    arrays = read_arrays(content, _FIELDS, where=where, fix=fix, error=ModelError)
    try:
        listed = arrays["tags"].tobytes().decode()
        tags = tuple(listed.split("\n")) if listed else ()
        (images,) = arrays["images"].tolist()
        pairs = (arrays["first"], arrays["second"])
        upper = sparse.coo_array((arrays["count"], pairs), shape=(len(tags), len(tags)))
    except ValueError as error:
        raise ModelError(f"it is no tag table: {error}", where=where, fix=fix) from error
    lower = sparse.tril(upper.T, -1)
    return TagTable(tags, sparse.csr_array(upper + lower), images)


def _parts(images: Iterable[frozenset[str]]) -> Iterator[list[frozenset[str]]]:
    stream = iter(images)
    while part := list(islice(stream, _LINES_AT_ONCE)):
        yield part
