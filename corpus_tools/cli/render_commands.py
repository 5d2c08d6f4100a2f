"""``ct render-videos``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options import FORMAT, WORKERS, out_folder, tell, with_default
from corpus_tools.runtime.terminal import note

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from corpus_tools.video.items import Item
    from corpus_tools.video.manifest import Settings
    from corpus_tools.video.production import OnFrameCount, Outcome

SMALLEST, LARGEST = 64, 4096
"""Lengths of a picture's edges, in pixels."""


@click.command("render-videos")
@click.argument("scenarios", nargs=-1)
@out_folder("Where to put a folder for each scenario; made if it isn't there.")
@click.option(
    "--dataset",
    metavar="DATASET",
    help="Where scenarios are looked for by name: a folder or a bundled dataset [default: "
    "warehouse].",
)
@click.option(
    "--corpus", metavar="CORPUS", help="Replay the logs of a corpus, rather than scenarios."
)
@click.option("--only", metavar="PATTERN", help='Only those whose names match, such as "dock_*".')
@with_default(
    "--camera",
    type=click.Choice(["track", "overview", "follow", "operator"]),
    default="track",
    help="From above, all and then what happens; from above, all; behind the robot; the driver's.",
)
@with_default("--size", metavar="WxH", default="1280x720", help="Width and height in pixels.")
@with_default("--fps", type=click.IntRange(1, 120), default=25, help="Frames per second.")
@with_default(
    "--quality",
    type=click.Choice(["draft", "standard", "high"]),
    default="standard",
    help="Without shadows; smooth, with shadows; drawn wholly by MuJoCo, slowest.",
)
@with_default(
    "--speed",
    type=click.FloatRange(0.1, 20),
    default=1.0,
    help="Seconds of what happens that a second of video shows. The log keeps its times.",
)
@click.option("--skip-idle", is_flag=True, help="Cut short where nothing moves for over 2 s.")
@click.option("--names", is_flag=True, help="Paint the names of places on the ground.")
@WORKERS
@click.option("--force", is_flag=True, help="Make again what is there already.")
@FORMAT
@click.pass_context
def render_videos(
    ctx: click.Context,
    *,
    scenarios: tuple[str, ...],
    out: Path,
    dataset: str | None,
    corpus: str | None,
    only: str | None,
    camera: str,
    size: str,
    fps: int,
    quality: Literal["draft", "standard", "high"],
    speed: float,
    skip_idle: bool,
    names: bool,
    workers: Workers,
    force: bool,
    form: str,
) -> None:
    """Make videos and logs of what happens in scenarios.

    SCENARIOS are files, or names in the dataset; without any, all of it are rendered. Each
    gets a folder in OUT with video.mp4, poster.png, segmentation.png and segmentation.json
    (what is where in the first frame), log.mcap and manifest.json. A folder is there as a
    whole or not at all. What is there already, made of the same input by the same program,
    is skipped: run again to resume after an interruption.

    The exit status is 0 if all are there, 1 if one failed by an error of ct, 2 by its input.

    \b
    Examples:
      ct render-videos --out videos
      ct render-videos dock_pick_up_tires --out videos --camera follow --size 640x480
      ct render-videos my_scenario.yaml --out videos --quality draft
      ct render-videos --corpus aaai11 --only "*_tire_*" --out replays --jobs 4
      ct render-videos --corpus aaai11 --out replays --camera track --speed 2 --skip-idle
      ct render-videos --out videos --json
      ct render-videos --out /shared/videos --scheduler tcp://head:8786
    """
    from fnmatch import fnmatchcase

    if corpus is not None and (scenarios or dataset):
        raise click.UsageError("Give either scenarios or --corpus.")
    pixels = _size(size)

    # Before MuJoCo is imported, which reads what this chooses.
    from corpus_tools.video.drawing.gl import choose_back_end

    choose_back_end()

    from corpus_tools.video.items import context_items, scenario_items
    from corpus_tools.video.manifest import Settings
    from g3.errors import CorpusError, unknown_name

    source = corpus or dataset or "warehouse"
    items = context_items(source) if corpus else scenario_items(source, scenarios)
    chosen = [item for item in items if only is None or fnmatchcase(item.name, only)]
    if not chosen:
        lister = f"ct corpus stats {source}" if corpus else "ct scenarios list"
        there = [item.name for item in items]
        what, fix = unknown_name("name like", only, there, more=f"`{lister}` lists all")
        raise CorpusError(what, where=source, fix=fix)
    out.mkdir(exist_ok=True)
    settings = Settings(camera, pixels, fps, quality, speed, skip_idle, names)
    outcomes = _produce(chosen, out, settings, workers=workers, force=force)
    ctx.exit(_report(outcomes, out, form))


def _size(text: str) -> tuple[int, int]:
    import re

    match = re.fullmatch(r"(\d{1,5})[xX](\d{1,5})", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if any(length % 2 or not SMALLEST <= length <= LARGEST for length in size):
        raise click.UsageError(
            f"--size: {text!r} is not WIDTHxHEIGHT in even numbers from {SMALLEST} to {LARGEST}, "
            "such as 1280x720."
        )
    return size


def _produce(
    items: list[Item], out: Path, settings: Settings, *, workers: Workers, force: bool
) -> list[Outcome]:
    from corpus_tools.runtime.progress import progress_bar
    from corpus_tools.video.production import produce_all

    outcomes: list[Outcome] = []
    with progress_bar("rendering") as progress:

        def on_frame(name: str) -> OnFrameCount:
            def told(done: int, total: int) -> None:
                progress(f"{name} ({len(outcomes) + 1} of {len(items)})", done, total)

            return told

        for outcome in produce_all(
            items, out, settings, workers=workers, force=force, on_frame=on_frame
        ):
            outcomes.append(outcome)
            progress("rendering", len(outcomes), len(items))
    return outcomes


def _report(outcomes: list[Outcome], out: Path, form: str) -> int:
    """Print the result of each item, and return the exit status."""
    failed = [outcome for outcome in outcomes if outcome.problem]
    for outcome in failed:
        note(f"ct: {outcome.name}: {' '.join(outcome.problem.split())}")
    names = {
        "skipped": [o.name for o in outcomes if not o.made and not o.problem],
        "rendered": [o.name for o in outcomes if o.made],
    }
    record = {"folder": out, **names, "failed": {o.name: o.problem for o in failed}}
    counts = {**{what: len(those) for what, those in names.items()}, "failed": len(failed)}
    tell(form, record, ", ".join(f"{what} {n}" for what, n in counts.items() if n))
    if any(outcome.is_bug for outcome in failed):
        return 1
    return 2 if failed else 0
