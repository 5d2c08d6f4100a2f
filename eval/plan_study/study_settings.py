"""Settings of a study of plans, kept in its folder."""

from __future__ import annotations

from pathlib import Path

import msgspec

from corpus_tools.importers.authored.bundled import open_corpus
from g3.errors import FormatError
from g3.storage.atomic_file import write_bytes

SETTINGS = "settings.json"


class Settings(msgspec.Struct, frozen=True):
    """Settings of a study; a folder holds one study only."""

    train: str
    """Names of the training corpora, with commas between; the tested scenario is held out."""
    test: str
    most: int
    """Number of commands of each scenario; 0 for all."""
    l2: float
    seed: int
    hashes: tuple[str, ...] = ()
    plans: tuple[str, ...] = ()
    """Verdicts of the plans in a rating set: ``wrong`` or ``right`` by the automatic judge, in
    order of priority; empty for a study like the paper's."""
    pairs: int = 0
    """Largest number of pairs in a rating set; 0 for all."""


def settings_for(
    train: str, test: str, *, most: int, l2: float, seed: int, plans: tuple[str, ...] = ()
) -> Settings:
    """Return settings with the hashes of the corpora.

    `most` is how many commands of each scenario, or how many pairs of a rating set; 0 for all.
    """
    hashes = tuple(open_corpus(name).hash for name in (*train.split(","), test))
    if plans:
        return Settings(train, test, 0, l2, seed, hashes, plans, most)
    return Settings(train, test, most, l2, seed, hashes)


def check_settings(folder: Path, settings: Settings) -> None:
    """Begin a study's folder; a FormatError if it is another study's, or holds other things."""
    path = folder / SETTINGS
    if not path.exists():
        if folder.exists() and any(folder.iterdir()):
            raise FormatError(
                "the folder holds other things", where=str(folder), fix="choose another name"
            )
        folder.mkdir(exist_ok=True)
        write_bytes(path, msgspec.json.format(msgspec.json.encode(settings)) + b"\n")
    elif msgspec.json.decode(path.read_bytes(), type=Settings) != settings:
        raise FormatError(
            "the folder is of another study: corpora or options differ",
            where=str(path),
            fix="give the same ones, or choose another folder",
        )
