"""A study's videos and commands, wherever they come from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from annotation_app.studies.study_file import StudyConfig
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


def study_videos(path: Path, only: tuple[str, ...] = ()) -> Sequence[Rendered | OwnVideo]:
    """The videos of a folder or a table.

    Raises
    ------
    CorpusError
        If there are none, or one that is wanted is missing.
    """
    if not is_own(path):
        return rendered_videos(path, only)
    found = own_videos(path)
    missing = set(only) - {item.video for item in found}
    if missing:
        raise FormatError(
            f"there is no video of {min(missing)}",
            where=str(path),
            fix=f"the videos are: {', '.join(item.video for item in found[:20])}",
        )
    return [item for item in found if not only or item.video in only]


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
