"""Data that word-label similarity needs: where they are, and what to do where they are not.

Like a parser's model, a dictionary is part of the language model and is read from where it is
installed when it is first needed; all other files are the business of ``corpus_tools``.
What was read of WordNet is kept as arrays in the folder for caches.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from g3.errors import FormatError, ModelError
from g3.language.parsing.encoder import default_encoder
from g3.language.similarity.cooccurrence import TagTable, count_list, table_from_bytes
from g3.language.similarity.vectors import PieceVectors, Vectors, WordVectors, read_vectors
from g3.language.similarity.wordnet import WordNet, read_wordnet
from g3.language.similarity.wordnet_tables import (
    TABLES_VERSION,
    wordnet_from_bytes,
    wordnet_to_bytes,
)
from g3.storage import regular_file
from g3.storage.atomic_file import write_bytes
from g3.storage.cache_folder import cache_folder
from g3.storage.text_lines import decode_text, split_lines

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

    Like all functions here, it raises a ModelError if that isn't there or can't be read.
    """
    return _read_wordnet(_wordnet_folder())


def wordnet_identity() -> str:
    """Return an identity of WordNet: a digest of its nouns."""
    return _digest("WordNet", _INSTALL_WORDNET, *_wordnet_files(_wordnet_folder()))


def tag_table() -> TagTable:
    """The tag table named in CT_TAGS, else the bundled one, made by hand; read once."""
    return _read_tag_table(_tag_file())


def tag_table_identity() -> str:
    """Return an identity of the tag table: a digest of its file."""
    return _digest("the tag table", _MEND_TAGS, _tag_file())


def word_vectors() -> Vectors:
    """The vectors of words in the file named in CT_VECTORS, read once; else the bundled ones."""
    file = _vectors_file()
    return _read_word_vectors(file) if file else PieceVectors()


def word_vectors_identity() -> str:
    """Return an identity of the vectors of words: their digest."""
    file = _vectors_file()
    return _digest("the vectors of words", _MEND_VECTORS, file) if file else _piece_digest()


def _wordnet_folder() -> Path:
    return _find_wordnet(os.environ.get(WORDNET_VARIABLE, ""))


@cache
def _find_wordnet(named: str) -> Path:
    for folder in [named] if named else _WORDNET_FOLDERS:
        path = Path(folder).expanduser()
        if all((path / name).is_file() for name in _WORDNET_FILES[:3]):
            return path
    raise ModelError("WordNet is not there", where=named, fix=_INSTALL_WORDNET)


def _wordnet_files(folder: Path) -> list[Path]:
    """The files of WordNet; its counts don't come with every one."""
    *needed, counts = (folder / name for name in _WORDNET_FILES)
    return [*needed, counts] if counts.exists() else needed


@cache
def _read_wordnet(folder: Path) -> WordNet:
    """WordNet as it was kept, or else from its files, and then kept for the next time."""
    digest = _digest("WordNet", _INSTALL_WORDNET, *_wordnet_files(folder))
    with suppress(OSError, RuntimeError, ModelError):  # it isn't there, or damaged
        kept = _kept_at(digest)
        return wordnet_from_bytes(kept.read_bytes(), where=str(kept), fix="remove it")
    net = _parse_wordnet(folder)
    with suppress(OSError, RuntimeError, FormatError):  # nothing can be written, or there's no home
        kept = _kept_at(digest)
        kept.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(kept, wordnet_to_bytes(net))
    return net


def _kept_at(digest: str) -> Path:
    return cache_folder() / f"wordnet{TABLES_VERSION}-{digest.partition(':')[2][:16]}.msgpack"


def _parse_wordnet(folder: Path) -> WordNet:
    with _readable("WordNet", folder, _INSTALL_WORDNET):
        contents = [regular_file.read_bytes(file) for file in _wordnet_files(folder)]
        return read_wordnet(*contents, *[b""] * (len(_WORDNET_FILES) - len(contents)))


def _tag_file() -> Path:
    named = os.environ.get(TAGS_VARIABLE, "")
    return Path(named).expanduser() if named else Path(__file__).with_name("warehouse_tags.txt")


@cache
def _read_tag_table(file: Path) -> TagTable:
    with _readable("the tag table", file, _MEND_TAGS):
        content = regular_file.read_bytes(file)
        if content.startswith(b"PK"):
            return table_from_bytes(content, where=str(file), fix=_MEND_TAGS)
        return count_list(split_lines(decode_text(content, str(file))))


def _vectors_file() -> Path | None:
    named = os.environ.get(VECTORS_VARIABLE, "")
    return Path(named).expanduser() if named else None


@cache
def _piece_digest() -> str:
    encoder = default_encoder()
    digest = hashlib.sha256("\n".join(encoder.vocabulary).encode())
    digest.update(encoder.words.tobytes() + encoder.word_scales.tobytes())
    return f"sha256:{digest.hexdigest()}"


@cache
def _read_word_vectors(file: Path) -> WordVectors:
    with (
        _readable("the vectors of words", file, _MEND_VECTORS),
        regular_file.text_of(file) as lines,
    ):
        return read_vectors(lines)


@cache
def _digest(what: str, fix: str, *files: Path) -> str:
    digest = hashlib.sha256()
    for file in files:
        with _readable(what, file, fix), regular_file.opened(file) as content:
            for part in iter(lambda: content.read(1 << 20), b""):
                digest.update(part)
    return f"sha256:{digest.hexdigest()}"


@contextmanager
def _readable(what: str, where: Path, fix: str) -> Iterator[None]:
    """Make errors of files say what can't be read, and what to do."""
    try:
        yield
    except (OSError, EOFError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise ModelError(f"{what} can't be read: {why}", where=str(where), fix=fix) from error
