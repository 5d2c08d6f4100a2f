"""``ct demo``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from corpus_tools.options.format_option import TARGET_FOLDER
from corpus_tools.runtime.terminal import note, say

if TYPE_CHECKING:
    from eval.cli.demo_steps import Step


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

    from eval.cli.demo_steps import steps

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
