"""Copies of what people see, in a folder or an object store, for others to give out."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path, PurePosixPath
from urllib.parse import urlsplit

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.clips import ensure
from annotation_app.items.media import COPIED, VIDEOS, digest, media_type, public_name
from annotation_app.items.replaced_videos import FIX
from annotation_app.store.models import Media
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.errors import CorpusError, FormatError
from g3.storage.system_errors import about

STORE = "s3"
CACHED = "public, max-age=31536000, immutable"
"""A changed file has another name."""

Put = Callable[[Path, str, str], bool]
"""Copies a file to a name, with its type; whether it wasn't there already."""


def copy_media(session: Session, target: str, on_progress: OnProgress = no_progress) -> int:
    """Copy all missing videos and pictures under meaningless names; return their number.

    The target is a folder, or ``s3://bucket/prefix``. An error reports that the object store
    refuses, or that a video was replaced since it was shown to people.
    """
    put = _store(target) if urlsplit(target).scheme == STORE else _folder(Path(target))
    files = list(_files(session))
    copied = 0
    for number, (path, media) in enumerate(files, start=1):
        copied += put(path, public_name(media), media_type(media))
        on_progress("copying videos and pictures", number, len(files))
    return copied


def _files(session: Session) -> Iterator[tuple[Path, Media]]:
    known = select(Media).where(Media.role.in_(COPIED)).order_by(Media.id)
    for media in session.scalars(known):
        path = Path(media.path)
        ensure(path)
        if path.is_file():
            if media.role in VIDEOS and digest(path) != media.sha256:
                what = f"the file of the video {media.video!r} has been replaced"
                raise FormatError(what, where=str(path), fix=FIX)
            yield path, media


def _folder(folder: Path) -> Put:
    folder.mkdir(parents=True, exist_ok=True)

    def put(path: Path, name: str, _kind: str) -> bool:
        target = folder / name
        if target.exists():
            return False
        part = target.with_name(f".{name}.part")
        try:
            with about(target, instead_of=part):
                shutil.copyfile(path, part)
                part.replace(target)
        finally:
            part.unlink(missing_ok=True)
        return True

    return put


def _store(target: str) -> Put:
    import boto3  # noqa: PLC0415 - heavy
    from botocore.exceptions import BotoCoreError, ClientError  # noqa: PLC0415

    parts = urlsplit(target)
    client = boto3.client("s3")

    def put(path: Path, name: str, kind: str) -> bool:
        key = str(PurePosixPath(parts.path.strip("/")) / name)
        try:
            with suppress(ClientError):
                client.head_object(Bucket=parts.netloc, Key=key)
                return False
            with path.open("rb") as file:
                client.put_object(
                    Bucket=parts.netloc, Key=key, Body=file, ContentType=kind, CacheControl=CACHED
                )
        except (BotoCoreError, ClientError) as error:
            raise CorpusError(
                f"the object store refuses: {error}",
                where=target,
                fix="check the credentials, the bucket and AWS_ENDPOINT_URL_S3",
            ) from error
        return True

    return put
