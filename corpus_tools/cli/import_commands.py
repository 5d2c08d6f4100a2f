"""``ct import``: a command for each importer."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from corpus_tools.importers.importer_registry import Importer, importers
from corpus_tools.options import FORMAT, PATH, out_file, tell
from corpus_tools.runtime.progress import progress_bar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from corpus_tools.episodes.study_tables import EpisodeSource, StudyInput
    from corpus_tools.importers.report import ImportReport
    from corpus_tools.runtime.progress import OnProgress

SHOWN = 5
"""Number of record ids that the summary names for each note."""


@click.group("import")
def import_() -> None:
    """Import a corpus from another format.

    \b
    Example:
      ct import slu-core slu_core/data --out aaai11
    """


def _command(importer: Importer) -> click.Command:
    first = f"{importer.name} {importer.name.replace('-', '_')}"
    examples = [f"{first} --out corpus", f"{first} --out corpus --force --keep-going"]
    examples += [f"{importer.name} {example}" for example in importer.examples]
    listed = "\n      ".join(f"ct import {example}" for example in examples)
    help_text = f"""{importer.summary}

    {importer.description}

    Ids of people are stored as hashes with a secret salt only. Without --salt each import
    takes a new one and forgets it, so the hashes differ from import to import; the
    corpus's own hash doesn't depend on them.

    \b
    Examples:
      {listed}
    """

    @click.command(importer.name, help=help_text, short_help=importer.summary)
    @click.argument("path", type=PATH)
    @out_file("Folder for the corpus.", "CORPUS")
    @click.option("--force", is_flag=True, help="Replace the corpus that is there.")
    @click.option(
        "--keep-going",
        is_flag=True,
        help="Leave out the records that can't be read and list them, rather than fail.",
    )
    @click.option(
        "--salt",
        envvar="CT_SALT",
        show_envvar=True,
        help="Secret for the hashes that stand for people.",
    )
    @FORMAT
    def command(
        *,
        path: Path,
        out: Path,
        force: bool,
        keep_going: bool,
        salt: str | None,
        form: str,
        **options: str,
    ) -> None:
        import secrets

        from corpus_tools.corpus.corpus_model import Corpus
        from corpus_tools.importers.report import REPORT

        Corpus.check_target(out, force=force)
        with progress_bar("reading") as on_progress:
            corpus, report = importer.load()(
                path,
                salt=salt or secrets.token_hex(16),
                keep_going=keep_going,
                on_progress=on_progress,
                **options,
            )
        corpus.save(out, force=force, attachments={REPORT: report.to_bytes()})
        tell(form, {"folder": out, "report": report}, *_summary(report, out))

    for option in importer.options:
        command = click.option(
            f"--{option.name.replace('_', '-')}",
            option.name,
            default=option.default,
            show_default=True,
            metavar=option.metavar,
            type=click.Choice(option.choices) if option.choices else str,
            help=option.summary,
        )(command)
    return command


def _summary(report: ImportReport, out: Path) -> Iterator[str]:
    from corpus_tools.importers.report import REPORT

    if report.parts_there:
        yield f"imported {', '.join(report.parts_taken)}; there are {', '.join(report.parts_there)}"
    for what, count in report.counts.items():
        yield f"{count:6} {what}"
    for note in report.notes:
        names = ", ".join(note.records[:SHOWN])
        more = f" and {len(note.records) - SHOWN} more" if len(note.records) > SHOWN else ""
        yield f"note: {note.what}: {names}{more}"
    for name in report.missing:
        yield f"note: there is no {name}"
    for skipped in report.skipped:
        yield f"skipped: {skipped.error()}"
    yield f"imported into {out}; {out / REPORT} has the details"


for _importer in importers():
    import_.add_command(_command(_importer))


def _episode_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add what all importers of episodes have: where to, and which episodes and cameras."""
    for option in (
        FORMAT,
        click.option("--force", is_flag=True, help="Replace the tables that are there."),
        click.option(
            "--keep-going",
            is_flag=True,
            help="Leave out the episodes that can't be shown and list them, rather than fail.",
        ),
        click.option(
            "--curves/--no-curves",
            "has_curves",
            default=True,
            help="Show numbers, such as state and action, as curves below the videos "
            "[default: yes].",
        ),
        click.option(
            "--camera",
            "cameras",
            multiple=True,
            help="A camera that people see, the large one first [default: all that are no depth "
            "maps].",
        ),
        click.option(
            "--first", type=click.IntRange(1), metavar="N", help="Take the first N episodes."
        ),
        out_file("Folder for the tables.", "FOLDER"),
    ):
        command = option(command)
    return command


_PATH = click.argument("path", type=PATH)
_FPS = click.option(
    "--fps",
    type=click.FloatRange(0, 1000, min_open=True),
    help="Frames a second, where the dataset gives none or wrong ones.",
)


def _write_tables(
    make: Callable[[Path, OnProgress], StudyInput], out: Path, *, force: bool, form: str
) -> None:
    """Write the tables that are made, with a folder for films, and say what comes next."""
    from corpus_tools.episodes.study_tables import EPISODES, write_tables
    from corpus_tools.runtime.terminal import note_all

    with progress_bar("reading episodes") as on_progress:
        made = write_tables(lambda scratch: make(scratch, on_progress), out, force=force)
    note_all(made.notes)
    lines = [f"{count:6} rows in {out / name}" for name, count in made.rows.items()]
    following = f"next: ct annotate init study.yaml --videos {out / EPISODES}"
    record = {"folder": out, "rows": made.rows, "notes": made.notes}
    tell(form, record, *lines, following)


def _write_recorded(
    opened: Callable[[], EpisodeSource], out: Path, *, force: bool, form: str, **options: Any
) -> None:
    """Write the tables of episodes whose pictures become videos."""
    from corpus_tools.episodes.study_tables import study_input

    def make(scratch: Path, on_progress: OnProgress) -> StudyInput:
        return study_input(opened(), out, scratch, on_progress=on_progress, **options)

    _write_tables(make, out, force=force, form=form)


@import_.command("lerobot", short_help="Episodes of a LeRobot dataset, as tables for studies.")
@click.argument("path", type=PATH, required=False)
@click.option(
    "--repo-id", metavar="NAME", help="Fetch this dataset of the Hugging Face Hub: OWNER/NAME."
)
@_episode_options
def lerobot(
    *,
    path: Path | None,
    repo_id: str | None,
    out: Path,
    force: bool,
    form: str,
    **options: Any,
) -> None:
    """Import episodes of a LeRobot dataset, for people to describe, cut and rate.

    PATH is a dataset's folder, of version 2.0, 2.1 or 3; with --repo-id it is fetched into
    huggingface_hub's cache, which needs the extra hub. This writes tables for studies:
    episodes.csv, tasks.csv and, if the dataset has language, subtasks.csv and moments.csv. Videos
    aren't copied: the tables name them. Of episodes that are pictures, videos are made beside the
    tables. docs/how-to/robot-episodes.md shows the whole way.

    \b
    Examples:
      ct import lerobot pick-and-place --out episodes
      ct import lerobot droid --camera observation.images.wrist --first 50 --out wrist
      ct import lerobot --repo-id lerobot/pusht --out episodes
    """
    from corpus_tools.lerobot.episode_reading import open_dataset
    from corpus_tools.lerobot.hub import fetch
    from corpus_tools.lerobot.study_input import study_input

    if (path is None) == (repo_id is None):
        raise click.UsageError("Give either a dataset's folder or --repo-id NAME.")

    def make(scratch: Path, on_progress: OnProgress) -> StudyInput:
        dataset = open_dataset(path or fetch(repo_id or ""))
        return study_input(dataset, out, scratch=scratch, on_progress=on_progress, **options)

    _write_tables(make, out, force=force, form=form)


@import_.command("robomimic", short_help="Episodes of robomimic's HDF5, as tables for studies.")
@_PATH
@_episode_options
@_FPS
def robomimic(
    *, path: Path, out: Path, fps: float | None, force: bool, form: str, **options: Any
) -> None:
    """Import episodes of HDF5 files, for people to describe, cut and rate.

    PATH is a file that robomimic, MimicGen, RoboCasa or LIBERO has written, or a folder of such
    files. This writes tables for studies, episodes.csv and tasks.csv, and makes videos beside them.
    docs/how-to/other-episodes.md has more. It needs the extras hdf5 and render.

    \b
    Examples:
      ct import robomimic lift/ph/image.hdf5 --out episodes
      ct import robomimic libero_spatial --camera eye_in_hand_rgb --first 50 --out wrist
    """
    from corpus_tools.episodes.robomimic import open_demonstrations

    _write_recorded(
        lambda: open_demonstrations(path, fps=fps), out, force=force, form=form, **options
    )


@import_.command("rlds", short_help="Episodes of an RLDS dataset, as tables for studies.")
@_PATH
@_episode_options
@_FPS
def rlds(
    *, path: Path, out: Path, fps: float | None, force: bool, form: str, **options: Any
) -> None:
    """Import episodes of an RLDS dataset, for people to describe, cut and rate.

    PATH is the folder that TensorFlow Datasets has written: dataset_info.json, features.json and
    TFRecord shards. TensorFlow isn't needed. This writes tables for studies, episodes.csv and
    tasks.csv, and makes videos beside them. docs/how-to/other-episodes.md has more. It needs the
    extras rlds and render.

    \b
    Examples:
      ct import rlds bridge_dataset/1.0.0 --first 50 --fps 5 --out episodes
      ct import rlds droid/1.0.1 --camera observation/wrist_image_left --out wrist
    """
    from corpus_tools.episodes.rlds import open_steps

    _write_recorded(lambda: open_steps(path, fps=fps), out, force=force, form=form, **options)


@import_.command("rosbag", short_help="MCAP files and ROS bags, as tables for studies.")
@_PATH
@_episode_options
@_FPS
def rosbag(
    *, path: Path, out: Path, fps: float | None, force: bool, form: str, **options: Any
) -> None:
    """Import recordings of robots, for people to describe, cut and rate.

    PATH is an MCAP file, a ROS 2 bag (a folder, or a .db3 file), a ROS 1 bag, or a folder of these;
    each is an episode. Its cameras are the topics with compressed images, compressed video or raw
    images. This writes tables for studies and makes videos beside them.
    docs/how-to/other-episodes.md has more. It needs the extras ros and render.

    \b
    Examples:
      ct import rosbag run-17.mcap --camera /camera/color/image_raw/compressed --out episodes
      ct import rosbag bags --first 50 --out episodes
    """
    from corpus_tools.episodes.rosbag import open_recordings

    _write_recorded(lambda: open_recordings(path, fps=fps), out, force=force, form=form, **options)
