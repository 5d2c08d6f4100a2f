"""``ct demo``: other commands of ct, one after the other, with their results."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
from click.core import ParameterSource

from corpus_tools.options import TARGET_FOLDER
from corpus_tools.runtime.terminal import note, say

CORPUS = "warehouse"
SHOWN = ("hall_pick_up_boxes", "court_put_crate_on_trailer")
FOLLOWED = ("Put the tire pallet on the truck", "hall_put_tires_in_storage")
LEARNED_LAYOUTS = ("court", "hall", "dock")
TESTED = {"court_put_crate_on_trailer": 2, "dock_pick_up_tires": 2, "hall_pick_up_boxes": 2}
"""Number of commands that get plans, and the scenarios that they come from."""

CAMERAS = ("track", "operator")
SIZE, FPS = "480x270", 10
PLANTED = "planted.json"
STUDY = """\
# A study of robot episodes. docs/annotation.md lists all fields.
name: forklift-episodes
title: A forklift at work
videos: tables/episodes.csv
commands: tables/tasks.csv
subtasks: tables/subtasks.csv
robot: forklift
tasks:
  describe: {answers: 1, practice: false}
  subtasks: {answers: 1, practice: false}
  correct: {answers: 1, practice: false}
  mark: {answers: 1, practice: false}
consent: |
  You will watch short videos of a robot {robot}, and write or judge what it does.
  What you type is kept on this machine. You may stop at any time by closing the page.
"""


@click.group(
    invoke_without_command=True,
    epilog="\b\nExamples:\n  ct demo\n  ct demo --out /tmp/demo\n  ct demo episodes",
)
@click.option(
    "--out",
    type=TARGET_FOLDER,
    default=Path("demo"),
    show_default=True,
    help="Folder for the results.",
)
@click.pass_context
def demo(ctx: click.Context, *, out: Path) -> None:
    """Show everything once on the bundled corpus, in minutes.

    Videos, Table 1, a command followed in physics, Table 3 on a few commands by the automatic
    judge, and a report. It prints each step, which is another command of ct. Existing results
    are kept, so that an interrupted demo can be resumed; delete the folder to start again.
    """
    if ctx.invoked_subcommand:
        if ctx.get_parameter_source("out") is ParameterSource.COMMANDLINE:
            raise click.UsageError(f"Give --out after {ctx.invoked_subcommand}.")
        return
    out.mkdir(exist_ok=True)
    minutes = take(steps(out), go_on=True) / 60
    say(f"\nAll done in {minutes:.1f} minutes. Now:")
    say(f"  open {out / 'report' / 'report.html'} in a browser, and watch {out / 'follow.mp4'}")
    say(f"  {out / 'table-1.txt'} is Table 1, {out / 'table-3.json'} Table 3 of six commands")
    say("  ct annotate    to have people describe, annotate and rate the videos")


@dataclass(frozen=True, slots=True)
class Step:
    """A step: its command line, and its result."""

    title: str
    line: str
    made: Path
    run: Callable[[], object]


def command_step(
    title: str, command: click.Command, made: Path, first: str, *others: str | Path
) -> Step:
    """Return a command as a step, from its first words and arguments that may contain blanks."""
    name, *arguments = [*first.split(), *map(str, others)]
    run = partial(command.main, args=arguments, prog_name=f"ct {name}", standalone_mode=False)
    return Step(title, shlex.join(["ct", name, *arguments]), made, run)


def take(plan: Sequence[Step], *, go_on: bool) -> float:
    """Take the steps whose results aren't there, and return the time that it took, in seconds.

    Parameters
    ----------
    go_on
        True to take the steps after one that made nothing. Otherwise the command ends there, with
        that step's exit status.
    """
    from time import monotonic

    start = monotonic()
    for number, step in enumerate(plan, start=1):
        say(click.style(f"[{number}/{len(plan)}] {step.title}", bold=True), styled=True)
        if step.made.exists():
            say(f"      it is there: {step.made}")
            continue
        say(f"      $ {step.line}")
        status = _status(step)
        if status:  # the command has printed the reason
            note(f"      that ended with status {status}")
        if step.made.exists():
            say(f"      made {step.made}")
        elif not go_on:
            raise click.exceptions.Exit(status or 1)
    return monotonic() - start


def _status(step: Step) -> int:
    """Take a step, and return its exit status."""
    try:
        result = step.run()
    except SystemExit as ended:
        result = ended.code
    return result if isinstance(result, int) else 0


def steps(out: Path) -> list[Step]:
    """Return all steps, in their order, with results in a folder."""
    from corpus_tools.cli.follow_commands import follow
    from corpus_tools.cli.render_commands import render_videos
    from eval.cli.eval_commands import evaluate

    videos, few, tested = out / "videos", out / "few", out / "few-tested"
    plans, report = out / "table-3.json", out / "report"
    text, scenario = FOLLOWED
    return [
        command_step(
            "Two videos of the forklift, from physics",
            render_videos,
            videos / SHOWN[-1] / "manifest.json",
            f"render-videos {' '.join(SHOWN)} --out",
            videos,
            *("--quality", "draft", "--fps", "15"),
        ),
        command_step(
            "Training on two thirds of the scenarios; Table 1 on the others",
            evaluate,
            out / "table-1.txt",
            f"eval table1 --split scenario --corpus {CORPUS} --out",
            out / "table-1.txt",
        ),
        command_step(
            "Following a command in physics; the model is trained on the first time",
            follow,
            out / "follow.mcap",
            "follow",
            text,
            *("--scenario", scenario, "--video", out / "follow.mp4"),
        ),
        Step(
            "A corpus of a few scenarios, to learn from",
            f"(all commands of the scenarios in {', '.join(LEARNED_LAYOUTS)})",
            few,
            partial(write_few, few),
        ),
        Step(
            "A corpus of a few commands, to make plans for",
            f"({sum(TESTED.values())} commands of {len(TESTED)} scenarios)",
            tested,
            partial(write_few, tested, TESTED),
        ),
        command_step(
            "Plans for them, each scenario held out, and the automatic judge: Table 3",
            evaluate,
            plans,
            "eval table3 --format json --train",
            few,
            *("--test", tested, "--out", plans),
        ),
        command_step(
            "A report of it all",
            evaluate,
            report / "report.html",
            "eval report",
            report,
            *("--corpus", CORPUS, "--repeats", "0", "--plans", plans, "--videos", videos),
        ),
    ]


def write_few(path: Path, most: dict[str, int] | None = None) -> None:
    """Write some scenarios' bundled commands, `most` of each, or all of :data:`LEARNED_LAYOUTS`."""
    from corpus_tools.corpus.corpus_model import Corpus
    from corpus_tools.importers.authored.bundled import open_corpus

    whole = open_corpus(CORPUS)
    left = dict(most) if most else None
    chosen = set()
    for command in whole.commands.values():
        if left is None:
            if command.scenario.startswith(LEARNED_LAYOUTS):
                chosen.add(command.id)
        elif left.get(command.scenario, 0):
            left[command.scenario] -= 1
            chosen.add(command.id)
    annotations = [a for a in whole.annotations if a.command.id in chosen]
    corpus = Corpus.build(
        path.name,
        contexts=list({a.context.id: a.context for a in annotations}.values()),
        commands=[c for c in whole.commands.values() if c.id in chosen],
        annotations=annotations,
        source=whole.source,
        licence=whole.licence,
    )
    corpus.save(path)


@demo.command(
    epilog="\b\nExamples:\n  ct demo episodes\n  ct demo episodes --out /tmp/forklift --no-serve"
)
@click.option(
    "--out",
    type=TARGET_FOLDER,
    default=Path("demo-episodes"),
    show_default=True,
    help="Folder for the dataset, the study and its answers.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8765,
    show_default=True,
    help="Port of the study; 0 for any that is free.",
)
@click.option("--no-serve", is_flag=True, help="Make all, and print how to start the study.")
@click.pass_context
def episodes(ctx: click.Context, *, out: Path, port: int, no_serve: bool) -> None:
    """Make LeRobot episodes, and a study that corrects them.

    Four episodes of the bundled corpus, filmed by two cameras, with a task and subtasks such as a
    model writes them. Five mistakes are planted, and planted.json lists them. It prints each step;
    existing results are kept, so that an interrupted demo can be resumed. Delete the folder to
    start again. docs/tutorial-episodes.md goes on from there.
    """
    (out / "films").mkdir(parents=True, exist_ok=True)
    seconds = take(episode_steps(out), go_on=False)
    instance = out / "annotation"
    more = ("--format", "lerobot", "--instance", str(instance))
    say(
        f"\nAll is there after {seconds:.0f} s. The planted mistakes are in {out / PLANTED}: look "
        "when you have found them yourself.",
        "When you have answered, write your language into a copy of the dataset:",
        f"  {shlex.join(['ct', 'annotate', 'export', str(out / 'with-language'), *more])}",
    )
    arguments = [str(out / "study.yaml"), "--instance", str(instance)]
    if no_serve:
        say("Start the study:", f"  {shlex.join(['ct', 'annotate', *arguments])}")
        return
    root = ctx.find_root()
    assert isinstance(root.command, click.Group)  # noqa: S101 - it is ct, which has the app
    annotate = root.command.get_command(root, "annotate")
    assert annotate is not None  # noqa: S101
    annotate.main([*arguments, "--port", str(port)], "ct annotate", standalone_mode=False)


def episode_steps(out: Path) -> list[Step]:
    """Return the steps up to the study's file, in their order, with results in a folder."""
    from corpus_tools.cli.corpus_commands import corpus as corpus_commands
    from corpus_tools.cli.import_commands import import_
    from corpus_tools.cli.render_commands import render_videos
    from eval.cli.forklift_episodes import EPISODES, write_corpus, write_dataset
    from g3.storage.atomic_file import write_bytes

    corpus, films, recorded = out / "corpus", out / "films", out / "recorded"
    dataset, study = out / "dataset", out / "study.yaml"
    options = ("--quality", "draft", "--size", SIZE, "--fps", str(FPS))
    return [
        Step(
            "Four scenarios of the bundled corpus, with a task each",
            f"({', '.join(EPISODES)})",
            corpus,
            partial(write_corpus, corpus),
        ),
        *(
            command_step(
                f"Videos of them: the camera {camera}",
                render_videos,
                films / camera / list(EPISODES)[-1] / "manifest.json",
                "render-videos --corpus",
                corpus,
                *("--camera", camera, *options, "--out", films / camera),
            )
            for camera in CAMERAS
        ),
        command_step(
            "A LeRobot dataset with two cameras, state and action",
            corpus_commands,
            recorded,
            "corpus export",
            corpus,
            *("--to", "lerobot"),
            *(word for camera in CAMERAS for word in ("--videos", films / camera)),
            *("--out", recorded),
        ),
        Step(
            "Subtasks such as a model writes them, with planted mistakes",
            f"(a copy of {recorded} with subtasks and plans, and {PLANTED})",
            dataset,
            partial(write_dataset, recorded, dataset, out / PLANTED),
        ),
        command_step(
            "Tables for a study",
            import_,
            out / "tables",
            "import lerobot",
            dataset,
            *("--out", out / "tables"),
        ),
        Step(
            "A study: describe and mark the episodes, correct their subtasks and tasks",
            f"(write {study})",
            study,
            partial(write_bytes, study, STUDY.encode()),
        ),
    ]
