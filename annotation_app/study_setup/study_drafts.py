"""Studies that somebody is at work on in the browser, before they are written to their file.

A draft is a JSON file in the folder of studies. It has what the study's file will say.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from annotation_app.studies.study_file import Name
from corpus_tools.world.scenarios.documents import read_document
from g3.errors import FormatError
from g3.storage.atomic_file import write_bytes

FOLDER = ".drafts"


@dataclass(frozen=True, slots=True)
class StudyDraft:
    """A study that somebody is at work on.

    Parameters
    ----------
    name
        The study's.
    file
        Where its file is, or will be.
    value
        What that will say.
    base
        SHA-256 of the file when the draft was begun; empty for a new study.
    """

    name: str
    file: Path
    value: dict[str, Any] = field(default_factory=dict)
    base: str = ""

    @property
    def is_new(self) -> bool:
        """Whether there is no such study yet."""
        return not self.base


class _Kept(msgspec.Struct, frozen=True):
    file: str
    value: dict[str, Any]
    base: str


def is_name(name: str) -> bool:
    """Whether a study may be called so."""
    try:
        msgspec.convert(name, Name)
    except msgspec.ValidationError:
        return False
    return True


def begun(file: Path, name: str) -> StudyDraft:
    """A draft of the study that a file describes.

    Raises
    ------
    FormatError
        If the file can't be read.
    """
    document = read_document(file)
    if not isinstance(document.value, dict):
        raise FormatError("this is no study", where=str(file), fix="correct the file")
    return StudyDraft(name, file, document.value, sha256_of(file))


def find_draft(folder: Path, name: str) -> StudyDraft | None:
    """The draft of a study, if there is one."""
    path = _path(folder, name)
    try:
        kept = msgspec.json.decode(path.read_bytes(), type=_Kept)
    except OSError:
        return None
    except msgspec.DecodeError as error:
        raise FormatError(
            "this draft of a study can't be read", where=str(path), fix="delete it"
        ) from error
    return StudyDraft(name, Path(kept.file), kept.value, kept.base)


def drafts(folder: Path) -> list[str]:
    """The names of the studies with a draft."""
    return sorted(path.stem for path in (folder / FOLDER).glob("*.json"))


def keep_draft(folder: Path, draft: StudyDraft, value: dict[str, Any]) -> StudyDraft:
    """Keep what a draft says now.

    Raises
    ------
    FormatError
        If it can't be written.
    """
    path = _path(folder, draft.name)
    kept = _Kept(str(draft.file), value, draft.base)
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_bytes(path, msgspec.json.encode(kept))
    except OSError as error:
        raise FormatError(
            f"the draft can't be written: {error.strerror}",
            where=str(path),
            fix="let the program that serves the app write there",
        ) from error
    return replace(draft, value=value)


def drop_draft(folder: Path, name: str) -> None:
    """Forget a draft."""
    _path(folder, name).unlink(missing_ok=True)


def sha256_of(file: Path) -> str:
    """The digest of a file's content; empty if it isn't there."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""


def _path(folder: Path, name: str) -> Path:
    assert is_name(name)  # noqa: S101 - no other comes here, and none may lead elsewhere
    return folder / FOLDER / f"{name}.json"
