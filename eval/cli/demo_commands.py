"""``ct demo``: other commands of ct, one after the other, with their results."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click

from corpus_tools.options.format_option import TARGET_FOLDER
from corpus_tools.runtime.terminal import note, say

CORPUS = "warehouse"
SHOWN = ("hall_pick_up_boxes", "court_put_crate_on_trailer")
FOLLOWED = ("Put the tire pallet on the truck", "hall_put_tires_in_storage")
LEARNED_LAYOUTS = ("court", "hall", "dock")
TESTED = {"court_put_crate_on_trailer": 2, "dock_pick_up_tires": 2, "hall_pick_up_boxes": 2}
"""Number of commands that get plans, and the scenarios that they come from."""


@click.command(epilog="\b\nExamples:\n  ct demo\n  ct demo --out /tmp/demo")
@click.option(
    "--out",
    type=TARGET_FOLDER,
    default=Path("demo"),
    show_default=True,
    help="Folder for the results.",
)
def demo(*, out: Path) -> None:
    """Show everything once on the bundled corpus, in minutes.

    Videos, Table 1, a command followed in physics, Table 3 on a few commands by the automatic
    judge, and a report. It prints each step, which is another command of ct. Existing results
    are kept, so that an interrupted demo can be resumed; delete the folder to start again.
    """
    from time import monotonic

    out.mkdir(exist_ok=True)
    plan, start = steps(out), monotonic()
    for number, step in enumerate(plan, start=1):
        say(click.style(f"[{number}/{len(plan)}] {step.title}", bold=True), styled=True)
        _take(step)
    say(f"\nAll done in {(monotonic() - start) / 60:.1f} minutes. Now:")
    say(f"  open {out / 'report' / 'report.html'} in a browser, and watch {out / 'follow.mp4'}")
    say(f"  {out / 'table-1.txt'} is Table 1, {out / 'table-3.json'} Table 3 of six commands")
    say("  ct annotate    to have people describe, annotate and rate the videos")


def _take(step: Step) -> None:
    if step.made.exists():
        say(f"      it is there: {step.made}")
        return
    say(f"      $ {step.line}")
    try:
        step.run()
    except SystemExit as ended:
        # A command prints what it can't do; the steps after it go on all the same.
        if ended.code not in (0, None):
            note(f"      that ended with status {ended.code}")
    if step.made.exists():
        say(f"      made {step.made}")


@dataclass(frozen=True, slots=True)
class Step:
    """A step: its command line, and its result."""

    title: str
    line: str
    made: Path
    run: Callable[[], object]


def steps(out: Path) -> list[Step]:
    """Return all steps, in their order, with results in a folder."""
    from corpus_tools.cli.follow_commands import follow
    from corpus_tools.cli.render_commands import render_videos
    from eval.cli.eval_commands import evaluate

    videos, few, tested = out / "videos", out / "few", out / "few-tested"
    plans, report = out / "table-3.json", out / "report"
    text, scenario = FOLLOWED
    return [
        _command(
            "Two videos of the forklift, from physics",
            render_videos,
            videos / SHOWN[-1] / "manifest.json",
            f"render-videos {' '.join(SHOWN)} --out",
            videos,
            *("--quality", "draft", "--fps", "15"),
        ),
        _command(
            "Training on two thirds of the scenarios; Table 1 on the others",
            evaluate,
            out / "table-1.txt",
            f"eval table1 --split scenario --corpus {CORPUS} --out",
            out / "table-1.txt",
        ),
        _command(
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
        _command(
            "Plans for them, each scenario held out, and the automatic judge: Table 3",
            evaluate,
            plans,
            "eval table3 --format json --train",
            few,
            *("--test", tested, "--out", plans),
        ),
        _command(
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


def _command(
    title: str, command: click.Command, made: Path, first: str, *others: str | Path
) -> Step:
    """Return a command as a step, from its first words and arguments that may contain blanks."""
    name, *arguments = [*first.split(), *map(str, others)]
    run = partial(command.main, args=arguments, prog_name=f"ct {name}", standalone_mode=False)
    return Step(title, shlex.join(["ct", name, *arguments]), made, run)
