"""From a study's file to a study that people can take part in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.items.replaced_videos import check_not_replaced
from annotation_app.store.models import Study
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.study_setup.coco_things import read_things
from annotation_app.study_setup.corpus_study import put_commands
from annotation_app.study_setup.every_problem import gathering, together
from annotation_app.study_setup.own_videos import (
    MOST_NAMED,
    GivenCommand,
    OwnVideo,
    given_commands,
    is_own,
    own_videos,
)
from annotation_app.study_setup.prepared_videos import (
    check_readable,
    check_rendered,
    part_of,
    played_file,
    prepare,
)
from annotation_app.study_setup.proposed_subtasks import (
    Proposals,
    proposed_subtasks,
    put_proposals,
)
from annotation_app.study_setup.rendered_study import (
    Rendered,
    check_videos,
    knows_things,
    put_study,
    rendered_videos,
    spelled_names,
)
from annotation_app.study_setup.study_reading import read_study
from annotation_app.tasks.ground import named_things
from annotation_app.work.adoption import catch_up, settle_open
from annotation_app.work.assigning import share_among_groups
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.tables.file_names import normal_name
from corpus_tools.tables.table_reading import TABLES, OnNote, no_note
from corpus_tools.video.probe import file_digest
from g3.errors import CorpusError, FormatError


@dataclass(frozen=True, slots=True)
class StudyParts:
    """The videos and commands that make up a study, and its file, if it has one."""

    config: StudyConfig
    videos: Sequence[Rendered | OwnVideo]
    commands: Sequence[GivenCommand] = ()
    proposals: Proposals = field(default_factory=dict)
    file: Path | None = None
    notes: Sequence[str] = ()
    """Lines about files, rows and images that aren't used, or that were matched loosely."""

    @property
    def without_things(self) -> list[str]:
        """Names of the videos in which no things are known."""
        return [item.video for item in self.videos if not knows_things(item)]

    @property
    def things_known(self) -> set[bool]:
        """Which is so of any video: True that its things are known, False that they aren't."""
        return {knows_things(item) for item in self.videos}


def read_parts(file: Path, videos: Path | None = None) -> StudyParts:
    """Read a study's file, and find its commands and its `videos`, if they were moved.

    A CorpusError lists all that is wrong.
    """
    config = read_study(file)
    parts, errors = find_parts(config, file, videos)
    if errors:
        raise together(errors)
    return parts


def find_parts(
    config: StudyConfig,
    file: Path,
    videos: Path | None = None,
    *,
    are_played: bool = False,
    on_progress: OnProgress = no_progress,
) -> tuple[StudyParts, list[CorpusError]]:
    """Return a study's videos and commands, and all of their faults.

    `file` is where the study's file is, or will be. If videos `are_played`, they are decoded: they
    must be whole, and browsers must be able to play them.
    """
    errors: list[CorpusError] = []
    notes: list[str] = []
    found: Sequence[Rendered | OwnVideo] = ()
    commands: Sequence[GivenCommand] = ()
    proposals: Proposals = {}
    table = videos or file.parent / config.videos
    with gathering(errors):
        things = file.parent / config.things if config.things else None
        found = study_videos(table, config.only, things, notes.append)
    if not errors:
        with gathering(errors):
            check_videos(config, found)
        known = [item if isinstance(item, OwnVideo) else item.video for item in found]
        with gathering(errors):
            if config.commands is not None:
                given = file.parent / config.commands
                is_same = given.resolve() == table.resolve()
                commands = given_commands(given, known, notes.append, has_videos=is_same)
        with gathering(errors):
            named = config.subtasks or {}
            named = named if isinstance(named, dict) else {"": named}
            tables = {name: file.parent / path for name, path in named.items()}
            proposals = proposed_subtasks(tables, known, notes.append)
        if are_played:
            with gathering(errors):
                own = [item for item in found if isinstance(item, OwnVideo)]
                check_readable(own, on_progress)
            with gathering(errors):
                folders = [item.folder for item in found if isinstance(item, Rendered)]
                check_rendered(folders, on_progress)
    notes = list(dict.fromkeys(notes))
    return StudyParts(config, found, commands, proposals, file, notes), errors


def study_videos(
    path: Path,
    only: tuple[str, ...] = (),
    things: Path | None = None,
    on_note: OnNote = no_note,
) -> Sequence[Rendered | OwnVideo]:
    """Return the videos of a folder or a table; raise if there are none, or one is missing.

    `things` is a COCO file of what is where in their pictures, if they come from elsewhere.
    """
    if path.is_file() and not is_own(path):
        raise FormatError(
            f"a table of videos ends in {' or '.join(TABLES)}",
            where=str(path),
            fix="save it as CSV with commas between its cells, or name a folder",
        )
    if not is_own(path):
        if things is not None:
            raise FormatError(
                "what is where in videos of `ct render-videos` is known already",
                where=str(things),
                fix="leave out things",
            )
        return rendered_videos(path, only)
    found = own_videos(path, on_note)
    wanted = set(map(normal_name, only))
    missing = wanted - {normal_name(item.video) for item in found}
    if missing:
        raise FormatError(
            f"there is no video of {min(missing)}",
            where=str(path),
            fix=f"the videos are: {', '.join(item.video for item in found[:20])}",
        )
    files = {item.video: item.file for item in found}
    parts = {item.video: item.part for item in found if item.part is not None}
    known = {} if things is None else read_things(things, files, parts, on_note)
    return [
        replace(item, things=known.get(item.video))
        for item in found
        if not wanted or normal_name(item.video) in wanted
    ]


def changed_since_asked(session: Session, parts: StudyParts) -> list[FormatError]:
    """Find what was replaced in a study's files since people were asked about it.

    These are videos, and things of which answers and items hold the ids.
    """
    study = session.scalars(select(Study).where(Study.name == parts.config.name)).first()
    if study is None:
        return []
    own = [item for item in parts.videos if isinstance(item, OwnVideo)]
    there = spelled_names(session, study.id)
    files = {
        there.get(normal_name(item.video), item.video): [
            (part_of(camera).digest(file_digest(camera.file)), camera.file)
            for camera in (item, *item.views)
        ]
        for item in own
    }
    return [
        *check_not_replaced(session, study.id, files),
        *_things_gone(session, study, own, there),
    ]


def _things_gone(
    session: Session, study: Study, videos: Sequence[OwnVideo], there: Mapping[str, str]
) -> Iterator[FormatError]:
    """Yield an error for each video without things that answers or items name."""
    named = named_things(session, study.id)
    for item in videos:
        things = () if item.things is None else item.things.things
        video = there.get(normal_name(item.video), item.video)
        gone = named.get(video, set()) - {thing["id"] for thing in things}
        if gone:
            yield FormatError(
                f"people were asked about things in the video {item.video!r} that its COCO file no "
                f"longer has: annotations {', '.join(sorted(gone)[:MOST_NAMED])}",
                where=str(study.config.get("things") or study.file or study.name),
                fix="put the old file back, or give the new boxes these ids",
            )


def prepare_parts(
    parts: StudyParts, setup: Config, on_progress: OnProgress = no_progress
) -> list[Rendered]:
    """Prepare a study's videos, with pictures of them in the installation's folder."""
    base = setup.instance / "own-videos" / parts.config.name
    return [
        _prepared(item, base, on_progress) if isinstance(item, OwnVideo) else item
        for item in parts.videos
    ]


def put_parts(session: Session, parts: StudyParts, ready: list[Rendered], salt: bytes) -> Study:
    """Add a study to the database, or bring it up to date.

    `ready` is what :func:`prepare_parts` has made, which takes long if there are many videos. A
    CorpusError lists the videos that were replaced since people were asked about them.
    """
    if replaced := changed_since_asked(session, parts):
        raise together(replaced)
    before = session.scalars(select(Study).where(Study.name == parts.config.name)).first()
    had = {} if before is None else restored(before.config).tasks
    added = [] if before is None else [name for name in parts.config.tasks if name not in had]
    study = put_study(session, parts.config, ready, parts.file)
    put_commands(session, study, parts.commands, salt)
    put_proposals(session, study, parts.proposals)
    if before is not None:
        catch_up(session, study, added)
        for name, of_task in parts.config.tasks.items():
            if name in had and had[name].adoption != of_task.adoption:
                settle_open(session, study, name)
    share_among_groups(session, study)
    return study


def _prepared(item: OwnVideo, base: Path, on_progress: OnProgress) -> Rendered:
    folder = prepare(item, base, on_progress)
    views = tuple(played_file(view, prepare(view, base, on_progress)) for view in item.views)
    return Rendered(item.video, folder, played_file(item, folder), views, item.curves)
