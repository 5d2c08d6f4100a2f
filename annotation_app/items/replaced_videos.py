"""Detection of videos whose files were replaced after people had answered items about them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.clips import source_file, source_problem
from annotation_app.items.scenes import CURVES, VIEWS
from annotation_app.store.models import Answer, Item, Media, Slot
from g3.errors import FormatError

CAMERAS = ("video", *VIEWS)
SHOWN = (*CAMERAS, CURVES)
"""Roles of what people see of a video: each camera, and curves."""
FIX = "put the old file back, or give the new one another name or id"


def video_digests(session: Session, study_id: str) -> Mapping[str, str]:
    """Return the digest of the film of each of a study's videos, as people have seen it."""
    rows = session.execute(
        select(Media.video, Media.sha256).where(Media.study_id == study_id, Media.role == "video")
    )
    return dict(rows.all())


def replaced(session: Session, study_id: str, *, with_gone: bool = True) -> Iterator[FormatError]:
    """Find the videos of a study whose files are others than when it was set up, of any camera.

    Parameters
    ----------
    with_gone
        If videos are found, too, whose files have gone.

    Yields
    ------
    FormatError
        The error that names a video, its file and the remedy.
    """
    found = session.execute(
        select(Media.video, Media.path, Media.sha256)
        .where(Media.study_id == study_id, Media.role.in_(SHOWN))
        .order_by(Media.video, Media.role)
    )
    for video, path, sha256 in found:
        is_asked = with_gone or source_file(Path(path)).exists()
        if is_asked and (problem := source_problem(Path(path), sha256)):
            yield FormatError(f"the video {video!r} can't be shown: {problem}", fix=FIX)


def check_not_replaced(
    session: Session, study_id: str, files: Mapping[str, Sequence[tuple[str, Path]]]
) -> list[FormatError]:
    """Find videos that a set-up would replace although people have answered items about them.

    Parameters
    ----------
    files
        Present digest and file of each camera, the first one's first, by the video's name.

    Returns
    -------
    list of FormatError
        The errors that name each such video with a file that is another.
    """
    rows = session.execute(
        select(Media.video, Media.role, Media.sha256).where(
            Media.study_id == study_id, Media.role.in_(CAMERAS)
        )
    )
    before = {(video, role): sha256 for video, role, sha256 in rows}
    others = {
        video: file
        for video, cameras in files.items()
        for role, (sha256, file) in reversed([*zip(CAMERAS, cameras, strict=False)])
        if before.get((video, role), sha256) != sha256
    }
    if not others:
        return []
    asked = select(Item.payload).where(
        Item.study_id == study_id,
        Item.id.in_(select(Answer.item_id)) | Item.id.in_(_LEASED),
    )
    # Payloads are JSON, which databases compare in ways of their own.
    about = {payload.get("video") for payload in session.scalars(asked)}
    return [
        FormatError(
            f"the file of the video {video!r} has been replaced, or is cut at other times, since "
            "people were asked about it",
            where=str(others[video]),
            fix=FIX,
        )
        for video in sorted(others.keys() & about)
    ]


def asked_about(session: Session, study_id: str, file: Path) -> str:
    """Return the video of a file about which people have been asked; empty if there is none."""
    shown = session.execute(
        select(Media.video, Media.path).where(Media.study_id == study_id, Media.role.in_(SHOWN))
    )
    videos = {video for video, path in shown if source_file(Path(path)) == file}
    asked = select(Item.video).where(
        Item.study_id == study_id,
        Item.video.in_(videos),
        Item.id.in_(select(Answer.item_id)) | Item.id.in_(_LEASED),
    )
    return session.scalar(asked.limit(1)) or ""


_LEASED = select(Slot.item_id).where(Slot.person_id.is_not(None))
