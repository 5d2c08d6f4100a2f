"""``ct annotate export`` and ``import``: answers of a study as a corpus, a corpus as a study."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from annotation_app.cli.installation_commands import INSTALLATION, Place
from corpus_tools.options import FORMAT, JSON, PLAIN, TARGET, ExistingPath, tell
from corpus_tools.runtime.terminal import note, note_all

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from sqlalchemy.orm import Session

    from annotation_app.export.lerobot_export import PeoplesLanguage
    from annotation_app.store.models import Study
    from annotation_app.tasks.episode_parts import KeepFrom
    from corpus_tools.lerobot.hub import Pushed

REPORT = "meta/people_report.json"
"""File of a copy of a LeRobot dataset with the dashboard's counts and agreement."""
LEROBOT, RLDS, ROBOMIMIC, ROSBAG = "lerobot", "rlds", "robomimic", "rosbag"
"""Written into a copy of a dataset, where `ct corpus export` makes a new one."""
LANGUAGE = "language"
COPIES = (LEROBOT, RLDS, ROBOMIMIC, ROSBAG)
OF_EPISODES = (*COPIES, LANGUAGE)
"""Formats for studies of robot episodes."""
TAKERS = {"--episodes": COPIES, "--push-to": (LEROBOT,), "--keep-from": (LEROBOT,)}
"""Formats that take an option."""

STUDY_NAME = click.option(
    "--study", "study_name", metavar="NAME", help="Which study, if there are several."
)


@click.command()
@click.argument("out", type=TARGET)
@STUDY_NAME
@INSTALLATION
@click.option(
    "--format",
    "form",
    metavar="FORMAT",
    default="corpus",
    show_default=True,
    help="corpus to train on; treebank: its commands and trees alone; slu-core: the same in the "
    "layout of the AAAI-11 corpus; conllu: words with their clauses; csv, jsonl, parquet: all "
    "answers as they are; lerobot, rlds, robomimic, rosbag: a copy of the episodes' dataset with "
    "what people said; language: the same as JSON lines, for episodes of any format.",
)
@click.option(
    "--episodes",
    type=ExistingPath(),
    help="Where the dataset is, if it has moved: lerobot, rlds, robomimic, rosbag.",
)
@click.option(
    "--push-to",
    metavar="NAME",
    help="Also write the copy to this dataset of the Hugging Face Hub, OWNER/NAME; it is made, "
    "private, if there is none: lerobot.",
)
@click.option(
    "--keep-from",
    "least",
    metavar="LEAST",
    multiple=True,
    help="What an episode needs so as not to be listed for deletion: partly or success, and a "
    "quality from 1 to 5; may be given twice: lerobot. [default: partly]",
)
@click.option("--licence", default="", help="On what terms the corpus may be used.")
@click.option(
    "--with-excluded",
    is_flag=True,
    help="Also excluded answers, and why: csv, jsonl, parquet.",
)
@click.option("--force", is_flag=True, help="Replace what is there.")
@JSON
def export(
    *,
    out: Path,
    study_name: str | None,
    place: Place,
    form: str,
    episodes: Path | None,
    push_to: str | None,
    least: tuple[str, ...],
    licence: str,
    with_excluded: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Write what people have answered.

    \b
    Examples:
      ct annotate export my-corpus
      ct eval table1 --corpus my-corpus
      ct annotate export answers.csv --format csv
      ct annotate export for-slu-core --format slu-core
      ct annotate export my-dataset-with-language --format lerobot
      ct annotate export language.jsonl --format language
      ct annotate export marked --format lerobot --keep-from success --keep-from 3
    """
    from annotation_app.core.config import existing_instance
    from annotation_app.export import answer_tables
    from annotation_app.export import corpus_export as exports
    from annotation_app.serving import server as serving
    from annotation_app.store.database import opened, reading
    from annotation_app.store.schema import check_current
    from corpus_tools.corpus.corpus_model import Corpus
    from corpus_tools.exporters.export_registry import export_corpus_to
    from g3.storage.atomic_file import replacing

    told = "json" if as_json else PLAIN
    folders, keep_from = _folders(), _keep_from(least)
    of_formats = {"--episodes": episodes, "--push-to": push_to, "--keep-from": least}
    _check_options(form, folders, of_formats, with_excluded=with_excluded)
    push = _pushing(push_to)
    if form == "corpus":
        Corpus.check_target(out, force=force)
    config = existing_instance(*place)
    with (
        opened(config.database) as engine,
        reading(engine, one_state=True) as session,
    ):
        check_current(engine)
        study = exports.find_only_study(session, study_name)
        if form in answer_tables.TABLES:
            write = answer_tables.TABLES[form].write
            write = answer_tables.WITH_EXCLUDED[form] if with_excluded else write
            with replacing(out) as file:
                write(session, study, file)
            serving.note_on_this_machine(config, "exported", study.name, format=form)
            tell(told, {"files": [out]}, f"wrote {out}")
            return
        if form in OF_EPISODES:
            counts = _write_language(
                session, study, out, form, dataset=episodes, keep_from=keep_from, force=force
            )
        else:
            corpus = exports.export_corpus(session, study, licence=licence)
            counts = {
                "commands": len(corpus.commands),
                "annotations": len(corpus.annotations),
                "judgments": len(corpus.judgments),
            }
    if form == "corpus":
        corpus.save(out, force=force)
    elif form in folders:
        export_corpus_to(corpus, form, out, force=force)
    serving.note_on_this_machine(config, "exported", study.name, format=form)
    shown = counts if form not in OF_EPISODES else {k: n for k, n in counts.items() if n}
    summary = ", ".join(f"{count} {what}" for what, count in shown.items()) or "no answers"
    record: dict[str, object] = {"folder": out, **counts}
    lines = [f"wrote {out}: {summary}"]
    if push is not None and push_to is not None:
        record["pushed"] = pushed = push(out, push_to)
        serving.note_on_this_machine(config, "pushed", study.name, to=push_to, commit=pushed.commit)
        what = "pushed to {}: {}" if pushed.is_new else "{} has all of this already: {}"
        lines.append(what.format(push_to, pushed.url))
    tell(told, record, *lines)
    if form not in OF_EPISODES and not (corpus.annotations or corpus.judgments):
        note(
            "note: there are no annotations yet, so no model can learn from this corpus.",
            "People make them: Describe (type a command), then Segment (mark its clauses), then "
            "Ground (say what they mean)",
            "All answers as they are: --format csv",
        )


def _folders() -> set[str]:
    """Return the formats of corpora that are written as folders."""
    from annotation_app.export.answer_tables import TABLES
    from corpus_tools.exporters.export_registry import exporters

    # Answers as a table, where a corpus's table has the same name.
    names = {exporter.name for exporter in exporters() if not exporter.name.startswith(LEROBOT)}
    return names - {*TABLES}


def _check_options(
    form: str, folders: Collection[str], of_formats: Mapping[str, object], *, with_excluded: bool
) -> None:
    """Raise a FormatError for an unknown format, or an option that it doesn't take."""
    from annotation_app.export import answer_tables
    from g3.errors import FormatError

    known = ("corpus", *OF_EPISODES, *sorted(folders), *answer_tables.TABLES)
    if form not in known:
        raise FormatError.unknown("format", form, known)
    if with_excluded and form not in answer_tables.WITH_EXCLUDED:
        raise FormatError(
            "this format has no place for excluded answers",
            where=f"--format {form}",
            fix=f"use one of {', '.join(answer_tables.WITH_EXCLUDED)}",
        )
    for option, value in of_formats.items():
        takers = TAKERS[option]
        if value and form not in takers:
            listed = " and ".join(", ".join(takers).rsplit(", ", 1))
            what = f"only {listed} take{'s' * (len(takers) == 1)} {option[2:]}"
            raise FormatError(what, where=option, fix="leave it out")


def _pushing(name: str | None) -> Callable[[Path, str], Pushed] | None:
    """Return what pushes to a dataset of the hub, after a check that it can; None without one."""
    if name is None:
        return None
    from corpus_tools.lerobot.hub import check_can_push, push

    check_can_push(name)
    return push


def _write_language(
    session: Session,
    study: Study,
    out: Path,
    form: str,
    *,
    dataset: Path | None,
    keep_from: KeepFrom,
    force: bool,
) -> dict[str, int]:
    """Write people's answers about episodes, with a copy of their dataset; return the counts."""
    from annotation_app.export.lerobot_export import language_lines, peoples_language
    from g3.storage.atomic_file import replacing

    said = peoples_language(session, study, keep_from)
    if form == LANGUAGE:
        with replacing(out) as file:
            file.write(language_lines(said))
    elif form == LEROBOT:
        _write_lerobot(session, study, said, out, dataset=dataset, force=force)
    else:
        note_all(_write_copy(said, out, form, dataset or said.dataset, force=force))
    return dict(said.counts)


def _write_copy(
    said: PeoplesLanguage, out: Path, form: str, dataset: Path, *, force: bool
) -> list[str]:
    """Write a copy of a dataset of another format; return notes."""
    from annotation_app.export.lerobot_export import language_lines, rate_of
    from corpus_tools.episodes.copies import PEOPLE, LanguageCopy

    rates = {i: rate for i, row in said.episodes.items() if (rate := rate_of(row))}
    times = {index: str(row.get("start") or "") for index, row in said.episodes.items()}
    starts = {index: int(time) for index, time in times.items() if time.isdecimal()}
    files = {PEOPLE: language_lines(said)}
    copy = LanguageCopy(out, said.language, files, rates, starts, force)
    if form == RLDS:
        from corpus_tools.episodes.rlds import open_steps
        from corpus_tools.episodes.rlds_writing import write_rlds

        return write_rlds(open_steps(dataset), copy)
    if form == ROBOMIMIC:
        from corpus_tools.episodes.robomimic import open_demonstrations
        from corpus_tools.episodes.robomimic_writing import write_robomimic

        return write_robomimic(open_demonstrations(dataset), copy)
    from corpus_tools.episodes.bag_writing import write_recordings
    from corpus_tools.episodes.rosbag import open_recordings

    return write_recordings(open_recordings(dataset), copy)


def _keep_from(least: tuple[str, ...]) -> KeepFrom:
    """Read thresholds: the last of each kind counts."""
    from annotation_app.tasks.episode_parts import KeepFrom
    from g3.errors import FormatError

    found = KeepFrom()
    for one in least:
        if one in ("partly", "success"):
            found = replace(found, success=one)
        elif re.fullmatch(r"5|[1-4](\.\d+)?", one):
            found = replace(found, quality=float(one))
        else:
            raise FormatError(
                f"{one!r:.40} is no threshold",
                where="--keep-from",
                fix="give partly, success, or a quality from 1 to 5",
            )
    return found


def _write_lerobot(
    session: Session,
    study: Study,
    said: PeoplesLanguage,
    out: Path,
    *,
    dataset: Path | None,
    force: bool,
) -> None:
    """Write a copy of the episodes' dataset with people's answers."""
    from annotation_app.dashboard.consensus import agreement
    from annotation_app.dashboard.study_statistics import collected
    from annotation_app.export.lerobot_export import indented
    from annotation_app.tasks.mark import TO_DELETE
    from corpus_tools.lerobot.episode_reading import open_dataset
    from corpus_tools.lerobot.language_writing import write_language

    source = open_dataset(dataset or said.dataset)
    report = {
        "study": study.name,
        "collected": collected(session, study.id),
        "agreement": [one for one in agreement(session, study.id) if one.items],
    }
    notes = write_language(
        source,
        out,
        said.language,
        attachments={**said.files, REPORT: indented(report)},
        columns=said.columns,
        force=force,
    )
    note_all(notes)
    if TO_DELETE in said.files:
        place = shlex.quote(str(out / TO_DELETE))
        note(
            "note: to have LeRobot leave out the listed episodes in another copy, with a name of "
            "yours:",
            f"lerobot-edit-dataset --config_path={place} --repo_id=me/all "
            f"--root={shlex.quote(str(out))} --new_repo_id=me/kept "
            f"--new_root={shlex.quote(f'{out}-kept')}",
        )


@click.command("import")
@click.argument("corpus", metavar="CORPUS")
@click.option(
    "--videos",
    type=ExistingPath(file_okay=False),
    help="What `ct render-videos --corpus CORPUS --out FOLDER` has made [default: none, so that "
    "people see the words alone and correct the clauses].",
)
@STUDY_NAME
@INSTALLATION
@FORMAT
def import_corpus(
    *,
    corpus: str,
    videos: Path | None,
    study_name: str | None,
    place: Place,
    form: str,
) -> None:
    """Make a study of a corpus, to look at it and continue it.

    Without videos it is a study of texts: each command is an item of the task Segment, which begins
    with the clauses that the corpus has.

    \b
    Examples:
      ct render-videos --corpus aaai11 --out replays
      ct annotate import aaai11 --videos replays
      ct annotate import treebank
      ct annotate
    """
    from annotation_app.core.config import open_instance
    from annotation_app.serving import server as serving
    from annotation_app.store.database import opened, transaction
    from annotation_app.store.salt import installation_salt
    from annotation_app.studies.study_template import slug
    from annotation_app.study_setup import corpus_study
    from annotation_app.study_setup.rendered_study import rendered_videos
    from corpus_tools.importers.authored.bundled import open_corpus, resolve

    config = open_instance(*place)
    serving.prepare(config)
    found = open_corpus(corpus)
    name = study_name or slug(found.name)
    folder = resolve(corpus).resolve()
    rendered = None if videos is None else rendered_videos(videos)
    with opened(config.database) as engine:
        salt = installation_salt(engine, config)
        with transaction(engine) as session:
            counts = corpus_study.import_corpus(
                session, found, folder, rendered, name=name, salt=salt
            )
    summary = ", ".join(f"{n} {what}" for what, n in counts.items())
    tell(form, {"study": name, **counts}, f"study {name}: {summary}")
