"""A study's videos and commands, wherever they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from annotation_app.studies.study_file import StudyConfig
from annotation_app.study_setup.coco_things import read_things
from annotation_app.study_setup.own_videos import (
    GivenCommand,
    OwnVideo,
    given_commands,
    is_own,
    own_videos,
    played_file,
    prepare,
)
from annotation_app.study_setup.rendered_study import Rendered, rendered_videos
from g3.errors import FormatError


def study_videos(
    path: Path, only: tuple[str, ...] = (), things: Path | None = None
) -> Sequence[Rendered | OwnVideo]:
    """The videos of a folder or a table.

    Parameters
    ----------
    things
        COCO file of what is where in their pictures, if they come from elsewhere.

    Raises
    ------
    CorpusError
        If there are none, or one that is wanted is missing.
    """
    if not is_own(path):
        if things is not None:
            raise FormatError(
                "what is where in videos of `ct render-videos` is known already",
                where=str(things),
                fix="leave out things",
            )
        return rendered_videos(path, only)
    found = own_videos(path)
    missing = set(only) - {item.video for item in found}
    if missing:
        raise FormatError(
            f"there is no video of {min(missing)}",
            where=str(path),
            fix=f"the videos are: {', '.join(item.video for item in found[:20])}",
        )
    known = {} if things is None else read_things(things, {v.video: v.file for v in found})
    return [
        replace(item, things=known.get(item.video))
        for item in found
        if not only or item.video in only
    ]


def study_commands(
    config: StudyConfig, folder: Path, videos: Sequence[Rendered | OwnVideo]
) -> list[GivenCommand]:
    """The commands that a study's file names, if it does.

    Parameters
    ----------
    folder
        Of the study's file.
    """
    if config.commands is None:
        return []
    known = [item if isinstance(item, OwnVideo) else item.video for item in videos]
    return given_commands(folder / config.commands, known)


def prepared(videos: Sequence[Rendered | OwnVideo], base: Path) -> list[Rendered]:
    """The videos with what is made of those from elsewhere: manifests and posters."""
    return [_prepared(item, base) if isinstance(item, OwnVideo) else item for item in videos]


def _prepared(item: OwnVideo, base: Path) -> Rendered:
    folder = prepare(item, base)
    return Rendered(item.video, folder, played_file(item, folder))
