"""Videos and pictures, under names that say nothing, with ranges so that people can scrub."""

from __future__ import annotations

import functools
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flask import Blueprint, redirect, request, send_file, url_for
from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session
from werkzeug.wrappers import Response as BaseResponse

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.items.clips import CUT_VERSION, clip_digest, ensure, is_clip
from annotation_app.items.scenes import CURVES, VIEWS
from annotation_app.people.browser_sessions import required_person
from annotation_app.people.participants import RANKS, has_consented
from annotation_app.store.database import core, reading
from annotation_app.store.installation import installation
from annotation_app.store.models import Media, Person
from corpus_tools.video.probe import file_digest
from g3.errors import CorpusError

VIDEOS, PICTURES = ("video", *VIEWS), ("poster", "segmentation")
COPIED = (*VIDEOS, *PICTURES)
"""The roles of files that another server may send: pages show them, and read none of them."""
TYPES = {
    **dict.fromkeys(VIDEOS, "video/mp4"),
    **dict.fromkeys(PICTURES, "image/png"),
    CURVES: "application/octet-stream",
}
"""Media types of the kinds of a video's files that people may see."""

WEBM = "video/webm"

blueprint = Blueprint("media", __name__)
log = logging.getLogger(__name__)


@blueprint.get("/media/<media_id>")
def media(media_id: str) -> BaseResponse:
    """Send a file, or redirect to a copy, for participants of its study and for staff."""
    with reading(installation().engine) as session:
        person = required_person(session)
        found = session.get(Media, media_id)
    if found is None or found.role not in TYPES or not _may_see(person, found):
        raise Refusal(404, gettext("There is no such file."))
    copies = installation().config.media_url
    if copies and found.role in COPIED:
        elsewhere = redirect(f"{copies.rstrip('/')}/{public_name(found)}")
        elsewhere.headers["Cache-Control"] = "private, max-age=3600"
        return elsewhere
    path = Path(found.path)
    try:
        ensure(path)
        is_checked = found.role not in PICTURES
        is_as_asked = path.is_file() and not (is_checked and digest(path) != found.sha256)
    except CorpusError as error:
        log.warning("a video can't be shown: %s", error)
        is_as_asked = False
    if not is_as_asked:
        raise Refusal(404, gettext("There is no such file."))
    etag = f"{found.sha256}-{_cut(path)}"
    response = send_file(path, mimetype=media_type(found), conditional=True, etag=etag)
    response.headers["Cache-Control"] = "private, max-age=86400"
    response.headers.pop("Content-Disposition", None)
    response.headers.pop("Last-Modified", None)
    return response


def _may_see(person: Person, media: Media) -> bool:
    return RANKS[person.role] > RANKS["worker"] or has_consented(person, media.study_id)


@blueprint.app_template_filter("media_url")
def media_url(media_id: str) -> str:
    """Return the address of a file; those of practice examples have one already."""
    if media_id.startswith("/"):
        return f"{request.script_root}{media_id}"
    return url_for("media.media", media_id=media_id)


def media_type(found: Media) -> str:
    """Return the media type of a file."""
    return WEBM if Path(found.path).suffix.lower() == ".webm" else TYPES[found.role]


def public_name(found: Media) -> str:
    """Return the name of a file's copy: it reveals nothing, and changes with the file."""
    path = Path(found.path)
    return f"{found.id}-{found.sha256[:12]}{_cut(path)}{path.suffix}"


def _cut(path: Path) -> str:
    """Return a mark that differs between a cut video, its source and an earlier cut."""
    return f"c{CUT_VERSION}" if is_clip(path) else ""


@dataclass(frozen=True, slots=True)
class Files:
    """A video's files by their roles."""

    public: Mapping[str, str]
    """The names under which people may see some of them."""
    paths: Mapping[str, Path]
    """Paths of the files."""


MEDIA = core(Media)
_FILES = select(MEDIA.c.role, MEDIA.c.id, MEDIA.c.path).where(
    MEDIA.c.study_id == bindparam("study"), MEDIA.c.video == bindparam("video")
)


def media_files(session: Session, study_id: str, video: str) -> Files:
    """Return the files of a video."""
    rows = session.execute(_FILES, {"study": study_id, "video": video}).all()
    return Files(
        {role: name for role, name, _ in rows if role in TYPES},
        {role: Path(path) for role, _, path in rows},
    )


def media_path(session: Session, study_id: str, video: str, role: str) -> Path | None:
    """Return the path of one of a video's files, None if it has no such file."""
    return media_files(session, study_id, video).paths.get(role)


def digest(path: Path) -> str:
    """Return the SHA-256 of a file; for a part of a video, of the file's digest and its times."""
    known = clip_digest(path)
    if known is not None:
        return known
    status = path.stat()
    return _digest(path, status.st_mtime_ns, status.st_ctime_ns, status.st_size)


@functools.lru_cache(maxsize=65_536)
def _digest(path: Path, _changed_ns: int, _status_ns: int, _size: int) -> str:
    return file_digest(path)
