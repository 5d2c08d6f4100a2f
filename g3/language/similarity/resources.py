"""Data that word-label similarity needs: where they are, and what to do where they are not.

Like a parser's model, a dictionary is part of the language model and is read from where it is
installed when it is first needed; all other files are the business of ``corpus_tools``.
"""

from __future__ import annotations

import gzip
import hashlib
import os
from functools import cache
from pathlib import Path

from g3.errors import ModelError
from g3.language.similarity.cooccurrence import TagTable, count_list, table_from_bytes
from g3.language.similarity.vectors import WordVectors, read_vectors
from g3.language.similarity.wordnet import WordNet, read_wordnet

WORDNET_VARIABLE = "CT_WORDNET"
TAGS_VARIABLE = "CT_TAGS"
VECTORS_VARIABLE = "CT_VECTORS"

_WORDNET_FOLDERS = (
    "/usr/share/wordnet",
    "/usr/share/wordnet/dict",
    "/usr/share/WordNet/dict",
    "/usr/local/WordNet-3.0/dict",
    "/usr/local/share/wordnet/dict",
    "/opt/homebrew/opt/wordnet/dict",
    "/usr/local/opt/wordnet/dict",
    "~/nltk_data/corpora/wordnet",
    "/usr/share/nltk_data/corpora/wordnet",
)
_WORDNET_FILES = ("index.noun", "data.noun", "noun.exc", "cntlist.rev")
_INSTALL_WORDNET = (
    "install Debian's package wordnet-base (./setup does), "
    f"or name the folder with index.noun and data.noun in {WORDNET_VARIABLE}"
)

_MEND_TAGS = f"set {TAGS_VARIABLE} to a file of 'ct similarity build', or to nothing"
_MEND_VECTORS = f"set {VECTORS_VARIABLE} to a text file of vectors, such as GloVe's"


def wordnet() -> WordNet:
    """WordNet from the folder named in CT_WORDNET or a usual one, read once.

    Raises
    ------
    ModelError
        If it isn't installed or can't be read.
    """
    return _read_wordnet(_wordnet_folder())


def wordnet_identity() -> str:
    """What tells one WordNet from another: a digest of its nouns.

    Raises
    ------
    ModelError
        If it isn't installed or can't be read.
    """
    return _wordnet_digest(_wordnet_folder())


def tag_table() -> TagTable:
    """The tag table named in CT_TAGS, else the one made by hand that comes along, read once.

    Raises
    ------
    ModelError
        If the file can't be read.
    """
    return _read_tag_table(_tag_file())


def tag_table_identity() -> str:
    """What tells one tag table from another: a digest of its file.

    Raises
    ------
    ModelError
        If the file can't be read.
    """
    return _tag_digest(_tag_file())


def word_vectors() -> WordVectors:
    """The vectors of words in the file named in CT_VECTORS, read once; none come along.

    Raises
    ------
    ModelError
        If no file is named, or it can't be read.
    """
    return _read_word_vectors(_vectors_file())


def word_vectors_identity() -> str:
    """What tells one file of vectors from another: its digest.

    Raises
    ------
    ModelError
        If no file is named, or it can't be read.
    """
    return _vectors_digest(_vectors_file())


def _wordnet_folder() -> Path:
    return _find_wordnet(os.environ.get(WORDNET_VARIABLE, ""))


@cache
def _find_wordnet(named: str) -> Path:
    for folder in [named] if named else _WORDNET_FOLDERS:
        path = Path(folder).expanduser()
        if all((path / name).is_file() for name in _WORDNET_FILES[:3]):
            return path
    raise ModelError("WordNet is not there", where=named, fix=_INSTALL_WORDNET)


def _contents(folder: Path) -> list[bytes]:
    """The files of WordNet; its counts don't come with every one."""
    *needed, counts = (folder / name for name in _WORDNET_FILES)
    try:
        return [*(p.read_bytes() for p in needed), counts.read_bytes() if counts.exists() else b""]
    except OSError as error:
        raise ModelError(
            f"WordNet can't be read: {error.strerror}", where=str(folder), fix=_INSTALL_WORDNET
        ) from error


@cache
def _read_wordnet(folder: Path) -> WordNet:
    try:
        return read_wordnet(*_contents(folder))
    except ValueError as error:
        raise ModelError(
            f"WordNet can't be read: {error}", where=str(folder), fix=_INSTALL_WORDNET
        ) from error


@cache
def _wordnet_digest(folder: Path) -> str:
    return _digest(*_contents(folder))


def _tag_file() -> Path:
    named = os.environ.get(TAGS_VARIABLE, "")
    return Path(named).expanduser() if named else Path(__file__).with_name("warehouse_tags.txt")


def _tag_content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise ModelError(
            f"the tag table can't be read: {error.strerror}", where=str(file), fix=_MEND_TAGS
        ) from error


@cache
def _read_tag_table(file: Path) -> TagTable:
    content = _tag_content(file)
    try:
        if content.startswith(b"PK"):
            return table_from_bytes(content, where=str(file), fix=_MEND_TAGS)
        return count_list(content.decode().splitlines())
    except ValueError as error:
        raise ModelError(
            f"the tag table can't be read: {error}", where=str(file), fix=_MEND_TAGS
        ) from error


@cache
def _tag_digest(file: Path) -> str:
    return _digest(_tag_content(file))


def _vectors_file() -> Path:
    named = os.environ.get(VECTORS_VARIABLE, "")
    if not named:
        raise ModelError("there are no vectors of words", fix=_MEND_VECTORS)
    return Path(named).expanduser()


@cache
def _read_word_vectors(file: Path) -> WordVectors:
    opened = gzip.open if file.suffix == ".gz" else open
    try:
        with opened(file, "rt", encoding="utf-8", errors="replace", newline="\n") as lines:
            return read_vectors(lines)
    except (OSError, EOFError, ValueError) as error:
        raise _unreadable_vectors(file, error) from error


@cache
def _vectors_digest(file: Path) -> str:
    digest = hashlib.sha256()
    try:
        with file.open("rb") as content:
            for part in iter(lambda: content.read(1 << 20), b""):
                digest.update(part)
    except OSError as error:
        raise _unreadable_vectors(file, error) from error
    return f"sha256:{digest.hexdigest()}"


def _unreadable_vectors(file: Path, error: Exception) -> ModelError:
    why = getattr(error, "strerror", None) or error
    return ModelError(
        f"the vectors of words can't be read: {why}", where=str(file), fix=_MEND_VECTORS
    )


def _digest(*contents: bytes) -> str:
    digest = hashlib.sha256()
    for content in contents:
        digest.update(content)
    return f"sha256:{digest.hexdigest()}"
