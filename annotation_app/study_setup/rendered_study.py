"""Setting up a study in the database from its file and a folder of rendered videos."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec
from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.items.clips import is_clip
from annotation_app.items.media import digest
from annotation_app.items.new_items import (
    ABOUT_VIDEO,
    GIVEN,
    NewItem,
    about_video,
    add_item,
    new_slots,
    videos_of,
    wanted_answers,
)
from annotation_app.items.scenes import CURVES, VIEWS, read_film
from annotation_app.store.database import lock_set_up
from annotation_app.store.installation import now
from annotation_app.store.models import Item, Media, Slot, Study
from annotation_app.studies.study_file import StudyConfig, stored
from annotation_app.study_setup.every_problem import together
from annotation_app.study_setup.own_videos import OwnVideo
from annotation_app.tasks.task_registry import tasks
from corpus_tools.tables.file_names import normal_name
from corpus_tools.world.scenarios.documents import Field
from g3.errors import FormatError
from g3.storage import regular_file

FILES = {
    "manifest": "manifest.json",
    "video": "video.mp4",
    "poster": "poster.png",
    "segmentation": "segmentation.png",
}
"""The files of a rendered folder that the app uses, by their roles."""


_OF_VIDEOS = ("video", "wrong_video", "own_video")
"""The fields of a study's file that name videos."""


class SettingError(FormatError):
    """A setting of a study that its videos don't allow.

    Parameters
    ----------
    field
        The setting in the study's file.
    """

    def __init__(self, field: Field, what: str, *, where: str, fix: str) -> None:
        self.field = field
        super().__init__(what, where=where, fix=fix)


@dataclass(frozen=True, slots=True)
class Rendered:
    """A folder that ``ct render-videos`` has made of a scenario or a context, whose id is `video`.

    A video from elsewhere is the `file`; then it has no scene.
    """

    video: str
    folder: Path
    file: Path | None = None
    views: tuple[Path, ...] = ()
    """The files by further cameras."""
    curves: Path | None = None
    """A file of curves beside the video."""


def rendered_videos(folder: Path, only: tuple[str, ...] = ()) -> list[Rendered]:
    """Return the rendered folders in a folder; raise if there are none, or one is missing."""
    manifests = sorted(folder.glob(f"*/{FILES['manifest']}"))
    found = [Rendered(_id(path), path.parent.resolve()) for path in manifests]
    known = {item.video for item in found}
    missing = [name for name in only if name not in known]
    if missing or not found:
        raise FormatError(
            f"there is no video of {missing[0]}" if missing else "there are no videos",
            where=str(folder),
            fix=f"make them with `ct render-videos --out {folder}`, or name a folder of mp4 or "
            "webm files, or a table of them",
        )
    return [item for item in found if not only or item.video in only]


def put_study(
    session: Session, config: StudyConfig, videos: list[Rendered], file: Path | None = None
) -> Study:
    """Add a study, or bring an earlier study of the same name up to date.

    The database keeps its content: new videos are added, and slots where the file specifies more
    answers than before. The study's file stays the earlier one if it is left out. A CorpusError
    comes from :func:`check_videos`.
    """
    # Several processes may start at once, each with the study's file.
    lock_set_up(session.connection())
    check_videos(config, videos)
    study = session.scalars(select(Study).where(Study.name == config.name)).first()
    there = {} if study is None else spelled_names(session, study.id)
    videos = [replace(v, video=there.get(normal_name(v.video), v.video)) for v in videos]
    config = _with_names(config, {normal_name(item.video): item.video for item in videos})
    if study is None:
        study = Study(id=new_id(), name=config.name, config=stored(config), created_at=now())
        session.add(study)
    study.config = stored(config)
    study.file = str(file.resolve()) if file is not None else study.file
    session.flush()
    for item in videos:
        add_video(session, study.id, item)
    session.flush()
    for new in _first_items(session, study, config, videos):
        add_item(session, study, config, new)
    _add_slots(session, study, config)
    return study


def check_videos(config: StudyConfig, videos: Sequence[Rendered | OwnVideo]) -> None:
    """Check that the videos that a study names are there, and show what its tasks need.

    A CorpusError lists all attention checks, pairs and practice items that name another one, and
    the tasks about things if the things are known in no video.
    """
    names = {normal_name(item.video) for item in videos}
    wrong = [*_named_elsewhere(config, names), *_without_scenes(config, videos)]
    if wrong:
        where = f"study {config.name}"
        raise together(SettingError(at, what, where=where, fix=fix) for at, what, fix in wrong)


def spelled_names(session: Session, study_id: str) -> Mapping[str, str]:
    """Return a study's videos as they are spelled there, by their names in Unicode's normal form.

    A study's files may have been copied to a system that stores accents in another way.
    """
    return {normal_name(video): video for video in videos_of(session, study_id)}


def _with_names(config: StudyConfig, names: Mapping[str, str]) -> StudyConfig:
    """Spell the names of videos in a study's file as those in `names` are."""

    def spelled(value: Any) -> Any:
        if isinstance(value, (list, tuple)):
            return [spelled(inner) for inner in value]
        if not isinstance(value, dict):
            return value
        return {
            key: names.get(normal_name(inner), inner)
            if key in _OF_VIDEOS and isinstance(inner, str)
            else spelled(inner)
            for key, inner in value.items()
        }

    return msgspec.convert(spelled(msgspec.to_builtins(config)), StudyConfig)


def knows_things(item: Rendered | OwnVideo) -> bool:
    """Check that the things in a video are known."""
    if isinstance(item, OwnVideo):
        return item.things is not None
    return item.file is None or read_film(item.folder).has_things


def add_video(session: Session, study_id: str, item: Rendered) -> None:
    """Give a video's files names that say nothing, or keep those that they have."""
    files = dict(zip(VIEWS, item.views, strict=False))
    if item.curves is not None:
        files[CURVES] = item.curves
    gone = [role for role in (*VIEWS, CURVES) if role not in files]
    for role, name in FILES.items():
        path = item.file if role == "video" and item.file is not None else item.folder / name
        if path.is_file() or is_clip(path):
            files[role] = path
    put_media(session, study_id, item.video, files)
    of_video = (Media.study_id == study_id, Media.video == item.video)
    session.execute(delete(Media).where(*of_video, Media.role.in_(gone)))


def put_media(session: Session, study_id: str, video: str, files: Mapping[str, Path]) -> None:
    """Add a video's files by their roles, or record where they are now."""
    of_video = select(Media).where(Media.study_id == study_id, Media.video == video)
    there = {one.role: one for one in session.scalars(of_video)}
    for role, path in files.items():
        media = there.get(role)
        if media is None:
            media = Media(id=new_id(), study_id=study_id, video=video, role=role)
            session.add(media)
        media.path = str(path)
        media.sha256 = digest(path) if path.is_file() or is_clip(path) else ""
    session.flush()


def _id(manifest: Path) -> str:
    try:
        return str(msgspec.json.decode(regular_file.read_bytes(manifest))["id"])
    except (OSError, msgspec.DecodeError, KeyError, TypeError) as error:
        raise FormatError(
            "the manifest can't be read",
            where=str(manifest),
            fix="make the video again with `ct render-videos --force`",
        ) from error


def _first_items(
    session: Session, study: Study, config: StudyConfig, videos: list[Rendered]
) -> Iterator[NewItem]:
    """Yield the items that the study's tasks make of videos and of the study's file."""
    rows = session.execute(
        select(Media.video, Media.sha256).where(Media.study_id == study.id, Media.role == "video")
    )
    shas = {row.video: row.sha256 for row in rows}
    shown = [item.video for item in videos if item.video in shas]
    # A file's first video comes where the file did when items were about files alone.
    first = {sha256: video for video, sha256 in sorted(shas.items(), reverse=True)}
    places = {about_video(video, sha): f"{ABOUT_VIDEO}{sha}" for sha, video in first.items()}
    asked_about = select(Item.video).where(
        Item.study_id == study.id, Item.subject.startswith(ABOUT_VIDEO)
    )
    for task in tasks():
        if task.name in config.tasks:
            if task.of_video is not None:
                # One that is there stays, though its file may have been replaced meanwhile.
                asked = set(session.scalars(asked_about.where(Item.task == task.name)))
                new = (video for video in shown if video not in asked)
                of_videos = (task.of_video(video, shas[video]) for video in new)
                yield from (replace(i, drawn_with=places.get(i.subject, "")) for i in of_videos)
            yield from task.of_study(config)


def _named_elsewhere(config: StudyConfig, videos: set[str]) -> Iterator[tuple[Field, str, str]]:
    """Yield the fields that name videos that don't exist, their faults and their fixes."""
    known = f"the videos are: {', '.join(sorted(videos)[:20])}"
    for number, one in enumerate(config.known_commands):
        for name, video in (("video", one.video), ("wrong_video", one.wrong_video)):
            if normal_name(video) not in videos:
                what = f"a known command names the video {video!r}, which isn't there"
                yield ("known_commands", number, name), what, known
    for number, pair in enumerate(config.pairs):
        if normal_name(pair.video) not in videos:
            fix = "make the video with `ct render-videos`, or correct the name"
            what = f"pair {number + 1} names the video {pair.video!r}, which isn't there"
            yield ("pairs", number), what, fix
    for task, of_task in config.tasks.items():
        for number, item in enumerate(of_task.practice_items):
            if normal_name(item.video) not in videos:
                what = (
                    f"a practice item of {task} names the video {item.video!r}, which isn't there"
                )
                yield ("tasks", task, "practice_items", number, "video"), what, known


def _without_scenes(
    config: StudyConfig, videos: Sequence[Rendered | OwnVideo]
) -> Iterator[tuple[Field, str, str]]:
    if not videos or any(map(knows_things, videos)):
        return
    for task in tasks():
        if task.name in config.tasks and config.tasks[task.name].drawing:
            continue
        if task.needs_scenes and task.without_scenes is None and task.name in config.tasks:
            what = (
                f"the task {task.name} asks about the things in videos, and there is no file of "
                "the things in any of them"
            )
            fix = (
                f"leave out {task.name}, name a COCO file of boxes or outlines: things, or let "
                "people draw them: drawing"
            )
            yield ("tasks", task.name), what, fix


def _add_slots(session: Session, study: Study, config: StudyConfig) -> None:
    for task in config.tasks:
        counts = session.execute(
            select(Item, func.count(Slot.id))
            .outerjoin(Slot)
            .where(
                Item.study_id == study.id,
                Item.task == task,
                Item.attention.is_(False),
                ~Item.subject.startswith(GIVEN),
            )
            .group_by(Item.id)
        ).all()
        for item, count in counts:
            session.add_all(new_slots(item, wanted_answers(config, item) - count))
    session.flush()
