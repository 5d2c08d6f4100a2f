"""The files that were added to a draft's folder, with their uses in the study."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from annotation_app.store.installation import installation
from annotation_app.study_setup.own_videos import SUFFIXES, OwnVideo
from annotation_app.study_setup.study_drafts import StudyDraft
from annotation_app.study_setup.study_starting import StudyParts
from annotation_app.study_setup.uploads import PICTURES, Use, uploads, uses

LABELS: dict[Use, str] = {
    "videos": "the table of the videos",
    "commands": "the commands",
    "things": "what is where",
}
"""Uses of files, as people read them."""


@dataclass(frozen=True, slots=True)
class AddedFile:
    """A file in a draft's folder."""

    name: str
    bytes: int
    stamp: int
    """Changes when the file does."""
    used: str
    """Its use, as people read it; empty if it has none."""
    may_be: tuple[tuple[Use, str], ...]
    """Other uses that it may have, and their labels."""
    has_picture: bool


def folder_of(draft: StudyDraft) -> Path:
    """Return the folder of the files that are added to a draft."""
    return installation().config.studies_folder / f"{draft.name}-videos"


def added_files(draft: StudyDraft, parts: StudyParts | None) -> list[AddedFile]:
    """Return a draft's added files, those in use first."""
    of_videos = dict(_of_videos(parts))
    named = {field: draft.file.parent / str(draft.value.get(field) or "") for field in LABELS}
    found = []
    for file in uploads(folder_of(draft)):
        may_be = uses(file)
        used = [LABELS[use] for use in may_be if named[use].resolve() == file.resolve()]
        used += [of_videos[file.resolve()]] if file.resolve() in of_videos else []
        stat = file.stat()
        found.append(
            AddedFile(
                file.name,
                stat.st_size,
                stat.st_mtime_ns,
                " and ".join(used),
                tuple((use, LABELS[use]) for use in may_be if LABELS[use] not in used),
                file.suffix.lower() in (*SUFFIXES, *PICTURES),
            )
        )
    return sorted(found, key=lambda one: not one.used)


def _of_videos(parts: StudyParts | None) -> Iterator[tuple[Path, str]]:
    """Yield the files of the videos, and of what is shown with them, with their uses."""
    for item in parts.videos if parts is not None else ():
        if isinstance(item, OwnVideo):
            yield item.file.resolve(), "a video of the study"
            for view in item.views:
                yield view.file.resolve(), f"a camera of {item.video}"
            if item.curves is not None:
                yield item.curves.resolve(), f"the curves of {item.video}"
            if item.things is not None and item.things.picture is not None:
                yield item.things.picture.resolve(), f"the picture of {item.video}"
