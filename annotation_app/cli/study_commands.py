"""``ct annotate init`` and ``check``: a study's file, and what would stop people."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click

from annotation_app.cli.installation_commands import INSTALLATION, Place, existing
from corpus_tools.options import FORMAT, TARGET, ExistingPath, tell
from corpus_tools.runtime.terminal import note

STUDY_FILES = click.argument(
    "study_files",
    nargs=-1,
    metavar="[STUDY.yaml]...",
    type=ExistingPath("`ct annotate init` makes a study's file"),
)
VIDEOS = click.option(
    "--videos",
    type=ExistingPath(),
    help="Folder of `ct render-videos`, folder of mp4 and webm files, or table of such files, "
    "instead of the study's.",
)


@click.command()
@click.argument("study_file", metavar="STUDY.yaml", type=TARGET)
@click.option(
    "--videos",
    type=ExistingPath(),
    help="Your own videos: a folder of mp4 and webm files, a CSV or JSONL table of them, or a "
    "LeRobot dataset.",
)
@FORMAT
def init(*, study_file: Path, videos: Path | None, form: str) -> None:
    """Write a study's file to start from.

    For a LeRobot dataset, or the tables of ct import, the study's tasks are those for robot
    episodes. A dataset's tables are written beside the file; docs/how-to/robot-episodes.md shows
    the whole way.

    \b
    Examples:
      ct annotate init my-study.yaml
      ct annotate init my-robot.yaml --videos clips
      ct annotate init my-arm.yaml --videos pick-and-place
    """
    from annotation_app.studies.study_template import TEMPLATE, slug
    from g3.errors import FormatError
    from g3.storage.atomic_file import write_bytes

    if study_file.exists():
        raise FormatError("the file is there already", where=str(study_file), fix="name another")
    name, count, files = slug(study_file.stem), None, [study_file]
    notes: list[str] = []
    if videos is None:
        text = TEMPLATE.format(name=name)
    else:
        if (videos / "meta/info.json").is_file():
            videos = _tables_of(videos, study_file, notes)
            files.append(videos.parent)
        text, count = _own_study(name, videos, study_file.parent, notes)
    write_bytes(study_file, text.encode())
    shown = "" if count is None else f" for {count} video{'' if count == 1 else 's'}"
    show_notes(notes)
    record = {"files": files, "videos": count, "notes": notes}
    tell(form, record, f"wrote {' and '.join(map(str, files))}{shown}")


@click.command()
@STUDY_FILES
@VIDEOS
@INSTALLATION
@FORMAT
@click.pass_context
def check(
    ctx: click.Context,
    *,
    study_files: tuple[Path, ...],
    videos: Path | None,
    place: Place,
    form: str,
) -> None:
    """Say what would stop people in a study.

    For example, tasks that nobody may do, missing videos, or no admin.

    With STUDY.yaml it checks these files, otherwise all studies of the instance. It counts on the
    people who have a login there. It changes nothing. The exit status is 2 if something would
    stop people.

    \b
    Examples:
      ct annotate check my-study.yaml
      ct annotate check --instance /srv/g3/annotation
    """
    from annotation_app.core.config import no_installation
    from annotation_app.study_setup.readiness import (
        NOBODY,
        Obstacle,
        obstacles,
        people_by_role,
        study_obstacles,
    )
    from annotation_app.study_setup.study_reading import read_study
    from annotation_app.study_setup.study_starting import changed_since_asked, find_parts
    from annotation_app.work.assigning import group_sizes
    from corpus_tools.runtime.progress import progress_bar

    found: list[Obstacle] = []
    notes: list[str] = []
    with existing(place) as session:
        if session is None and not study_files:
            raise no_installation(place.instance)
        logins = NOBODY if session is None else people_by_role(session)
        sizes = None if session is None else group_sizes(session)
        for file in study_files:
            study = read_study(file)
            with progress_bar("looking at the videos") as on_progress:
                parts, errors = find_parts(
                    study, file, videos, are_played=True, on_progress=on_progress
                )
            if session is not None and not errors:
                errors += changed_since_asked(session, parts)
            notes += parts.notes
            for error in errors:
                where = f"{error.where}: " if error.where else ""
                found.append(Obstacle(study.name, f"{where}{error.what}", error.fix))
            known = parts.things_known
            found += study_obstacles(study, logins, {}, things_known=known, groups=sizes)
        if session is not None and not study_files:
            with progress_bar("looking at the videos") as on_progress:
                found += obstacles(session, on_progress=on_progress)
    what = ", ".join(map(str, study_files)) or str(place.instance)
    show_notes(notes)
    record = {"obstacles": found, "notes": notes}
    tell(form, record, *(map(str, found) if found else [f"{what}: nothing would stop people"]))
    ctx.exit(2 if found else 0)


def show_notes(notes: Iterable[str]) -> None:
    """Show what isn't used of people's tables and files, once each."""
    for line in dict.fromkeys(notes):
        note(f"note: {line}")


def _tables_of(dataset: Path, study_file: Path, notes: list[str]) -> Path:
    """Write the tables of a LeRobot dataset beside a study's file, and return that of videos."""
    from corpus_tools.episodes.study_tables import EPISODES, write_tables
    from corpus_tools.lerobot.episode_reading import open_dataset
    from corpus_tools.lerobot.study_input import study_input
    from corpus_tools.runtime.progress import progress_bar
    from g3.errors import FormatError

    folder = study_file.with_name(f"{study_file.stem}-tables")
    if folder.exists():
        fix = f"make a study of them: --videos {folder / EPISODES}; or delete them"
        raise FormatError("tables are there already", where=str(folder), fix=fix)
    opened = open_dataset(dataset)
    with progress_bar("reading episodes") as on_progress:
        made = write_tables(
            lambda scratch: study_input(opened, folder, scratch=scratch, on_progress=on_progress),
            folder,
            force=False,
        )
    notes += made.notes
    return folder / EPISODES


def _own_study(name: str, videos: Path, folder: Path, notes: list[str]) -> tuple[str, int]:
    """Return the file of a study of the user's videos, and the number of videos."""
    from annotation_app.studies.study_template import OWN_TEMPLATE
    from annotation_app.study_setup.own_videos import has_commands, own_videos
    from annotation_app.study_setup.prepared_videos import check_readable
    from corpus_tools.episodes.study_tables import is_of_episodes
    from corpus_tools.runtime.progress import progress_bar
    from corpus_tools.tables.table_reading import TABLES

    found = own_videos(videos, notes.append)
    with progress_bar("looking at the videos") as on_progress:
        check_readable(found, on_progress)
    if is_of_episodes(videos):
        return _episodes_study(name, videos, folder), len(found)
    has = videos.suffix.lower() in TABLES and has_commands(videos)
    path = _path(videos, folder)
    commands = f"commands: {path}" if has else "# commands: commands.csv"
    return OWN_TEMPLATE.format(name=name, videos=path, commands=commands), len(found)


def _episodes_study(name: str, videos: Path, folder: Path) -> str:
    """Return the file of a study of the tables that `ct import` has written beside that of videos.

    Without tasks in the dataset there are none to correct.
    """
    from annotation_app.studies.study_template import EPISODES_TEMPLATE, GIVEN_TASKS
    from corpus_tools.episodes.study_tables import SUBTASKS, TASKS

    named = {"videos": videos.name, "commands": TASKS, "subtasks": SUBTASKS}
    tables = {key: table for key, table in named.items() if videos.with_name(table).is_file()}
    return EPISODES_TEMPLATE.format(
        name=name,
        tables="\n".join(f"{k}: {_path(videos.with_name(t), folder)}" for k, t in tables.items()),
        given_tasks=GIVEN_TASKS if "commands" in tables else "",
    )


def _path(path: Path, folder: Path) -> str:
    """Return a path as a study's file in a folder has it: quoted as YAML wants it."""
    import json
    import os

    return json.dumps(os.path.relpath(path, folder))
