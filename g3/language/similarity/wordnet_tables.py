"""WordNet's nouns as one file, which is read in an eighth of the time that its own files take."""

from __future__ import annotations

import hashlib

import msgspec

from g3.errors import ModelError
from g3.language.similarity.wordnet import WordNet

TABLES_VERSION = 2
"""Raised whenever the tables, or what they are computed from, change."""

_DIGEST_BYTES = hashlib.sha256().digest_size


class _Tables(msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True):
    senses: dict[str, tuple[int, ...]]
    hypernyms: dict[int, tuple[int, ...]]
    exceptions: dict[str, tuple[str, ...]]
    frequency: dict[int, int]
    information: dict[int, float]


def wordnet_to_bytes(net: WordNet) -> bytes:
    """WordNet and the information content of its synsets, after a digest of them."""
    information = {s: net.information(s) for s in net.hypernyms}
    tables = _Tables(
        dict(net.senses),
        dict(net.hypernyms),
        dict(net.exceptions),
        dict(net.frequency),
        information,
    )
    content = msgspec.msgpack.encode(tables)
    return hashlib.sha256(content).digest() + content


def wordnet_from_bytes(content: bytes, *, where: str, fix: str) -> WordNet:
    """Read what :func:`wordnet_to_bytes` gives.

    Parameters
    ----------
    content
        All bytes of the file.
    where, fix
        What to call it in an error, and what to do about it.

    Raises
    ------
    ModelError
        If it is something else, or damaged.
    """
    digest, tables = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    if hashlib.sha256(tables).digest() != digest:
        raise ModelError("the content is not what was written", where=where, fix=fix)
    try:
        found = msgspec.msgpack.decode(tables, type=_Tables)
    except msgspec.DecodeError as error:
        raise ModelError(f"this is no WordNet: {error}", where=where, fix=fix) from error
    return WordNet(
        found.senses, found.hypernyms, found.exceptions, found.frequency, found.information
    )
