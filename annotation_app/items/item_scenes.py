"""The world of an item's video, and the names of its things on the item's page."""

from __future__ import annotations

from collections.abc import Mapping

from sqlalchemy.orm import Session

from annotation_app.items.assignment import AnyItem
from annotation_app.items.media import media_files
from annotation_app.items.new_items import videos_of
from annotation_app.items.scenes import (
    Aliases,
    Film,
    Scene,
    aliases,
    film_payload,
    read_film,
    read_scene,
)
from annotation_app.store.models import Record


def scene_of(session: Session, study_id: str, video: str) -> Scene:
    """Return the world of a video."""
    files = media_files(session, study_id, video)
    return read_scene(files.paths["manifest"].parent, files.paths.get("corpus"), video)


def films_of(session: Session, study_id: str) -> Mapping[str, Film]:
    """Return a study's films by their videos' names; without those whose files are away."""
    manifests = {
        video: media_files(session, study_id, video).paths["manifest"]
        for video in videos_of(session, study_id)
    }
    return {v: read_film(file.parent) for v, file in manifests.items() if file.is_file()}


def film_of(session: Session, study_id: str, video: str) -> Film | None:
    """Return one of a study's films; None if its files are away."""
    file = media_files(session, study_id, video).paths.get("manifest")
    return read_film(file.parent) if file is not None and file.is_file() else None


def film_of_item(session: Session, item: AnyItem) -> Film:
    """Return the film that an item is about; its files are there."""
    return read_film(
        media_files(session, item.study_id, item.payload["video"]).paths["manifest"].parent
    )


def has_things(session: Session, study_id: str, video: str) -> bool:
    """Check that the things in a video are known; true where no manifest denies it."""
    manifest = media_files(session, study_id, video).paths.get("manifest")
    return manifest is None or not manifest.is_file() or read_film(manifest.parent).has_things


def aliases_of(session: Session, item: AnyItem, video: str, salt: bytes) -> tuple[Scene, Aliases]:
    """Return a video's world and the names of its things in an item."""
    scene = scene_of(session, item.study_id, video)
    return scene, aliases(scene, item.id, salt)


def watched(session: Session, item: AnyItem) -> Record:
    """Return a page's data of an item's video.

    It has ``video``, ``poster``, ``duration_s``, ``fps`` and ``beside``.
    Studies of texts alone have no video.
    """
    return watched_video(session, item.study_id, item.payload["video"])


def watched_video(session: Session, study_id: str, video: str) -> Record:
    """Return a page's data of one of a study's videos, like :func:`watched`."""
    files = media_files(session, study_id, video)
    if "manifest" not in files.paths:
        return {"video": None}
    film = read_film(files.paths["manifest"].parent)
    return {
        "video": files.public.get("video"),
        "poster": files.public.get("poster"),
        "duration_s": film.duration_s,
        "fps": film.fps,
        "beside": film.beside.payload(files.public),
    }


def beside_video(session: Session, study_id: str, video: str) -> Record | None:
    """Return a page's data of what is shown beside a video; None if nothing is, or it is away."""
    files = media_files(session, study_id, video)
    manifest = files.paths.get("manifest")
    if manifest is None or not manifest.is_file():
        return None
    return read_film(manifest.parent).beside.payload(files.public)


def shown_film(session: Session, study_id: str, video: str) -> Record:
    """Return a page's data of a video whose things are unknown."""
    files = media_files(session, study_id, video)
    return film_payload(read_film(files.paths["manifest"].parent), files.public)
