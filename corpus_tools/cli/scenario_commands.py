"""``ct scenarios``: list, check, draw, generate and log scenarios."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from corpus_tools.options import FORMAT, TARGET_FILE, ExistingPath, out_folder, tell, with_default
from corpus_tools.runtime.terminal import note

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from corpus_tools.world.scenarios.scenario import Scenario

DATASET = with_default(
    "--dataset",
    default="warehouse",
    metavar="DATASET",
    help="Folder of a dataset, or the name of a bundled one.",
)


@click.group()
def scenarios() -> None:
    """Scenarios: what stands where, and what the robot does.

    \b
    Example:
      ct scenarios generate --seed 1 --count 200 --out scenarios
    """


@scenarios.command("list")
@DATASET
@FORMAT
def list_(dataset: str, form: str) -> None:
    """List a dataset's scenarios with their layouts and titles.

    \b
    Examples:
      ct scenarios list
      ct scenarios list --dataset my-dataset --json
    """
    from corpus_tools.world.scenarios.scenario_reading import (
        dataset_folder,
        read_scenario,
        scenario_files,
    )

    listed = [read_scenario(path) for path in scenario_files(dataset_folder(dataset)).values()]
    rows = [{"id": s.id, "layout": s.layout.name, "title": s.title} for s in listed]
    tell(form, {"scenarios": rows}, *_table(rows))


@scenarios.command()
@FORMAT
def kinds(form: str) -> None:
    """List the kinds of objects and actions of scenarios.

    \b
    Examples:
      ct scenarios kinds
      ct scenarios kinds --json
    """
    from corpus_tools.world.state.robot_script import ACTIONS
    from corpus_tools.world.state.thing_kinds import KINDS

    things = [
        {
            "kind": kind.name,
            "labels": " ".join(kind.labels),
            "size": "{:g} x {:g} m".format(*kind.size),
            "heights": "{:g} to {:g} m".format(*kind.heights),
            "use": "load" if kind.carriable else "carrier" if kind.deck else "",
        }
        for kind in KINDS.values()
    ]
    actions = [
        {"action": action.name, "argument": action.argument, "summary": action.summary}
        for action in ACTIONS.values()
    ]
    lines = (*_table(things), "", *_table(actions))
    tell(form, {"kinds": things, "actions": actions}, *lines)


@scenarios.command("naming-sheet")
@click.argument("kinds", nargs=-1)
@out_folder("Folder to write; it appears when all is in it.")
@click.option("--force", is_flag=True, help="Replace a sheet that was written before.")
@FORMAT
def naming_sheet(kinds: tuple[str, ...], out: Path, *, force: bool, form: str) -> None:
    """Draw every kind of thing as each camera sees it.

    OUT gets naming-sheet.jpg with all crops, a clip of each, things.csv, which says what they
    show, and study.yaml, a study in which people name them. KINDS are all kinds if none is given.

    \b
    Examples:
      ct scenarios naming-sheet --out naming
      ct scenarios naming-sheet crate box-pallet --out naming --force --json
    """
    from corpus_tools.world.state.thing_kinds import KINDS

    KINDS.check(kinds)
    # Before MuJoCo is imported, which reads what this chooses.
    from corpus_tools.video.drawing.gl import choose_back_end

    choose_back_end()

    from corpus_tools.runtime.progress import progress_bar
    from corpus_tools.video.naming_sheet import SHEET, crops, write_sheet

    drawn = []
    with progress_bar("drawing") as progress:
        for crop in crops(kinds):
            drawn.append(crop)
            progress(crop.kind, len(drawn), 3 * (len(kinds) or len(KINDS)))
    write_sheet(drawn, out, force=force)
    rows = [
        {"kind": c.kind, "camera": c.camera, "width_px": c.pixels[0], "height_px": c.pixels[1]}
        for c in drawn
    ]
    tell(form, {"folder": out, "things": rows}, f"{len(drawn)} clips, and {out / SHEET}")


@scenarios.command()
@click.argument("paths", nargs=-1, required=True, type=ExistingPath())
@FORMAT
@click.pass_context
def check(ctx: click.Context, paths: tuple[Path, ...], form: str) -> None:
    """Check scenario files or folders: every problem, by line.

    The exit status is 0 if all are right and 2 if there are problems.

    \b
    Examples:
      ct scenarios check my-scenario.yaml
      ct scenarios check datasets/warehouse/scenarios --json
    """
    from corpus_tools.world.scenarios.scenario_reading import all_errors

    files = [
        f for path in paths for f in (sorted(path.glob("*.yaml")) if path.is_dir() else [path])
    ]
    problems = [error for file in files for error in all_errors(file)]
    rows = [{"where": e.where, "what": e.what, "fix": e.fix} for e in problems]
    counts = f"{_count(len(files), 'scenario')}: {_count(len(problems), 'problem')}"
    tell(form, {"files": len(files), "problems": rows}, *map(str, problems), counts)
    if problems:
        ctx.exit(2)


@scenarios.command()
@click.argument("scenario", metavar="SCENARIO")
@DATASET
@click.option(
    "--out",
    type=TARGET_FILE,
    help="SVG file for a map, seen from above.",
)
@FORMAT
def show(scenario: str, dataset: str, out: Path | None, form: str) -> None:
    """Show what is in a scenario, given by its file or its name.

    \b
    Examples:
      ct scenarios show dock_pick_up_tires
      ct scenarios show my-scenario.yaml --out map.svg
    """
    from corpus_tools.world.scenarios.maps import draw_map
    from corpus_tools.world.scenarios.scenario_reading import (
        dataset_folder,
        read_scenario,
        scenario_file,
    )
    from g3.storage.atomic_file import write_bytes

    content = read_scenario(scenario_file(scenario, dataset_folder(dataset)))
    if out is not None:
        write_bytes(out, draw_map(content).encode())
    tell(form, content, *_lines(content))


@scenarios.command()
@click.option("--seed", required=True, type=click.IntRange(min=0), help="Seed of all chance.")
@click.option("--count", required=True, type=click.IntRange(min=1), help="How many.")
@click.option("--first", default=0, type=click.IntRange(min=0), help="Number of the first one.")
@out_folder("Folder for the files; it is made if it isn't there.")
@click.option("--layout", "layouts", multiple=True, help="Only these layouts.  [default: all]")
@DATASET
@FORMAT
def generate(
    *,
    seed: int,
    count: int,
    first: int,
    out: Path,
    layouts: tuple[str, ...],
    dataset: str,
    form: str,
) -> None:
    """Write random scenarios, of all kinds in turn.

    Things don't overlap, and the robot has room to get where it must go. The same seed gives the
    same files; how many there are changes none of them.

    \b
    Examples:
      ct scenarios generate --seed 1 --count 200 --out scenarios
      ct scenarios generate --seed 1 --count 10 --layout dock --layout yard --out scenarios
    """
    from corpus_tools.runtime.progress import progress_bar
    from corpus_tools.world.scenarios.random_scenarios import generate as make
    from corpus_tools.world.scenarios.scenario_files import format_scenario
    from corpus_tools.world.scenarios.scenario_reading import dataset_folder, read_layouts
    from g3.storage.atomic_file import write_bytes

    chosen_layouts = read_layouts(dataset_folder(dataset), layouts)
    out.mkdir(exist_ok=True)
    rows = []
    with progress_bar("generating") as on_progress:
        for number in range(first, first + count):
            made = make(seed, number, chosen_layouts)
            write_bytes(out / f"{made.id}.yaml", format_scenario(made).encode())
            rows.append({"id": made.id, "layout": made.layout.name, "title": made.title})
            on_progress("generating", len(rows), count)
    tell(form, {"folder": out, "scenarios": rows}, f"{_count(count, 'scenario')} in {out}")


@scenarios.command()
@click.argument("names", metavar="[SCENARIO]...", nargs=-1)
@DATASET
@FORMAT
def log(names: tuple[str, ...], dataset: str, form: str) -> None:
    """Execute a dataset's scenarios in physics and keep the logs.

    Without names, the scenarios whose logs are missing or show what they said before they
    were changed. Where the robot can't do what a scenario says, the others' logs are written all
    the same, and the exit status is 2.

    \b
    Examples:
      ct scenarios log
      ct scenarios log dock_pick_up_tires --dataset datasets/warehouse
    """
    from corpus_tools.runtime.progress import progress_bar
    from corpus_tools.world.scenarios.execution import log_scenario
    from corpus_tools.world.scenarios.scenario_logs import is_logged
    from corpus_tools.world.scenarios.scenario_reading import (
        dataset_folder,
        read_scenario,
        scenario_file,
        scenario_files,
    )
    from g3.errors import CorpusError

    folder = dataset_folder(dataset)
    files = [scenario_file(n, folder) for n in names] or list(scenario_files(folder).values())
    listed = [read_scenario(file) for file in files]
    to_execute = [s for s in listed if names or not is_logged(s, folder)]
    failures: dict[str, CorpusError] = {}
    with progress_bar("executing") as on_progress:
        for number, scenario in enumerate(to_execute):
            on_progress(f"executing {scenario.id}", number, len(to_execute))
            try:
                log_scenario(scenario, folder)
            except CorpusError as error:
                failures[scenario.id] = error
    record = {
        "folder": folder / "logs",
        "logged": [s.id for s in to_execute if s.id not in failures],
        "failed": {name: str(error) for name, error in failures.items()},
    }
    count = _count(len(to_execute) - len(failures), "log")
    tell(form, record, f"{count} written to {folder / 'logs'}")
    for failure in failures.values():
        note(f"ct: {failure}")
    if failures:
        click.get_current_context().exit(2)


def _count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def _table(rows: Sequence[dict[str, str]]) -> list[str]:
    from corpus_tools.runtime.text_tables import columns

    return columns([tuple(row.values()) for row in rows])


def _lines(scenario: Scenario) -> Iterable[str]:
    from corpus_tools.runtime.text_tables import columns

    def heading(yaw_deg: float) -> str:
        return f"heading {yaw_deg % 360:g}"

    def where(at: tuple[float, float] | None, deck: str | None) -> str:
        if at is None:
            return "on the forks"
        return "{:g}, {:g}".format(*at) + (f" on {deck}" if deck else "")

    yield f"{scenario.id}: {scenario.title}"
    yield f"\nLayout {scenario.layout.name}: {scenario.layout.title}"
    yield "x and y in metres, headings in degrees counter-clockwise from x, as in the file:"
    robot = scenario.robot
    rows = [
        *(
            (name, t.kind, where(t.at, t.deck), heading(t.yaw_deg) if t.at else "")
            for name, t in scenario.all_objects.items()
        ),
        *(
            (name, r.name or "(place)", where(r.at, r.deck), "")
            for name, r in scenario.all_places.items()
        ),
        ("forklift", "robot", where(robot.at, None), heading(robot.yaw_deg)),
    ]
    for line in columns(rows):
        yield f"  {line}"
    yield "\nScript"
    for i, step in enumerate(scenario.script, start=1):
        yield f"  {i}. {step.action} {step.argument}"
