"""``ct follow``: type a command, watch the forklift do it."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from corpus_tools.options import (
    FORMAT,
    PATH,
    PLAIN,
    TARGET_FILE,
    tell,
    text_argument,
    with_default,
)
from corpus_tools.runtime.terminal import note, say, visible
from g3.errors import CorpusError

if TYPE_CHECKING:
    from corpus_tools.following.plan_execution import Episode
    from g3.actions.robot_state import State
    from g3.inference.grounder import Grounder, Result

NOTHING = 2
"""Exit status where there is nothing to do, as for bad input."""
FAILED = 3
"""Exit status where a plan couldn't be carried out."""
UNSURE = 0.7
"""Probability below which a plan isn't carried out without a terminal to confirm it."""


@dataclass(frozen=True, slots=True)
class Shown:
    """The command's options of showing and carrying out plans."""

    form: str
    plan_only: bool
    yes: bool
    """True if plans are carried out without a question."""
    confirm_below: float
    """Probability below which a plan isn't carried out where nobody can confirm it."""
    search: dict[str, Any]
    """Options of :meth:`~g3.inference.grounder.Grounder.follow`."""

    @property
    def asks(self) -> bool:
        """True if there is somebody to ask."""
        return self.form == PLAIN and sys.stdin.isatty()


@click.command(
    epilog="\b\nExamples:\n"
    '  ct follow "Put the tire pallet on the truck" --scenario court_put_boxes_on_loaded_truck\n'
    '  ct follow "Pick up the boxes" --scenario dock_pick_up_tires --yes\n'
    '  ct follow "Pick up the boxes" --scenario dock_pick_up_tires --video out.mp4\n'
    '  ct follow "Go to the truck" --scenario court_go_to_second_truck --explain --top 3\n'
    '  ct follow "Go back 2 m and turn left 45 degrees" --scenario dock_pick_up_tires --plan-only\n'
    '  ct follow "Put it there" --scenario dock_pick_up_tires --plan-only --ablate last-goal\n'
    '  ct follow "Lift the tires" --context aaai11:move_tire_pallet --plan-only --json\n'
    "  ct follow --scenario dock_pick_up_tires --interactive"
)
@text_argument("text")
@click.option("--scenario", metavar="NAME|FILE", help="A scenario to follow the command in.")
@click.option(
    "--context",
    "context_name",
    metavar="CORPUS:ID",
    help="Or the start of a context of a corpus.",
)
@click.option(
    "--model",
    type=PATH,
    help="A model; left out, one trained on the bundled corpus is made once and kept (some "
    "minutes the first time).",
)
@click.option(
    "--video",
    type=TARGET_FILE,
    help="Show what happens: an MP4, with an MCAP log beside it.",
)
@click.option("--interactive", is_flag=True, help="Ask for one command after the other.")
@click.option("--plan-only", is_flag=True, help="Carry nothing out.")
@with_default("--top", type=click.IntRange(1, 20), default=1, help="How many plans to show.")
@with_default(
    "--parses",
    type=click.IntRange(1, 20),
    default=4,
    help="How many SDC trees of the command to sum over, where the best one is not sure.",
)
@click.option(
    "--ablate",
    metavar="NAME",
    multiple=True,
    help="Switch a potential off, which `ct features list` shows (repeatable).",
)
@click.option("--explain", is_flag=True, help="Show what each clause is grounded in, and why.")
@click.option(
    "--yes",
    "-y",
    is_flag=True,
    help="Do it without asking, with what there is if something isn't there.",
)
@with_default(
    "--confirm-below",
    type=click.FloatRange(0, 1),
    default=UNSURE,
    metavar="P",
    help="Without a terminal to ask on, do nothing that is less probable than this.",
)
@FORMAT
def follow(
    *,
    text: str | None,
    scenario: str | None,
    context_name: str | None,
    model: Path | None,
    video: Path | None,
    interactive: bool,
    plan_only: bool,
    top: int,
    parses: int,
    ablate: tuple[str, ...],
    explain: bool,
    yes: bool,
    confirm_below: float,
    form: str,
) -> None:
    """Find what a command means, and carry it out in physics.

    A plan is inferred in a scenario as in section 3.4. On a terminal you are asked which thing is
    meant where that is unclear, and before anything is carried out. In scripts and with --json
    nobody is asked: a sure plan is carried out.

    The exit status is 0 when it is done, 2 where nothing is done (something isn't there, the forks
    don't reach it, the plan isn't sure, you said no, the input is bad), and 3 where a step of the
    plan fails.
    """
    from corpus_tools.following.plan_execution import checked, run_plan

    _check_options(
        text, scenario, context_name, video, interactive=interactive, plan_only=plan_only
    )
    if text is not None:
        from g3.lengths import check_length

        check_length(text, where="TEXT")
    state = _start(scenario, context_name)
    grounder = _grounder(model, ablate)
    options: dict[str, Any] = {"top": top, "parses": parses, "explain": explain, "insist": yes}
    shown = Shown(form, plan_only, yes, confirm_below, options)
    if interactive:
        _loop(grounder, state, shown)
        return
    if text is None or not text.strip():
        raise CorpusError("the command is empty", fix="say what the robot is to do")
    result = grounder.follow(text, state, **options)
    if shown.asks and not yes:
        result = _asked(grounder, result, shown)
    result = checked(result)
    confirmed = _show(result, shown) and (plan_only or _confirmed(result, shown))
    if not confirmed:
        sys.exit(NOTHING)
    done = None
    if not plan_only and result.plan is not None:
        done = run_plan(state, result.plan.actions, video=video)
    _report(done, result, form, video)
    if done is not None and done.failure is not None:
        sys.exit(FAILED)


def _check_options(
    text: str | None,
    scenario: str | None,
    context_name: str | None,
    video: Path | None,
    *,
    interactive: bool,
    plan_only: bool,
) -> None:
    if (scenario is None) == (context_name is None):
        raise click.UsageError(
            "Give either --scenario or --context. `ct scenarios list` shows the bundled scenarios."
        )
    if interactive == (text is not None):
        raise click.UsageError("Give either TEXT or --interactive.")
    if interactive and video is not None:
        raise click.UsageError("--video shows one command; leave out --interactive.")
    if video is not None and (plan_only or video.suffix.lower() != ".mp4"):
        raise click.UsageError("--video needs a name that ends in .mp4, and no --plan-only.")
    if video is not None and not video.parent.is_dir():
        raise click.UsageError(f"--video: there is no folder {video.parent}; make it first.")


def _start(scenario: str | None, context_name: str | None) -> State:
    from corpus_tools.following.start_states import context_start, scenario_start

    if scenario is not None:
        return scenario_start(scenario)
    if not str(context_name).rpartition(":")[0]:
        raise click.UsageError("--context needs a corpus and the id of a context: CORPUS:ID.")
    return context_start(str(context_name))


def _grounder(model: Path | None, ablate: tuple[str, ...]) -> Grounder:
    from corpus_tools.following.bundled_grounder import default_model, kept_model
    from corpus_tools.runtime.progress import progress_bar
    from g3.inference.grounder import Grounder
    from g3.inference.potentials.potential_registry import check_potentials
    from g3.learning.grounding_model import GroundingModel

    without = check_potentials(ablate)
    bundled = kept_model() if model is None else GroundingModel.load(model)
    if bundled is None:
        with progress_bar("training on the bundled corpus") as on_progress:
            bundled = default_model(on_progress)
    return Grounder.load(bundled, without=without)


def _show(result: Result, shown: Shown) -> bool:
    """Show people the plans, or why nothing can be done; whether something can be."""
    plan = result.plan
    why_not = result.note if plan is None else plan.why_not
    if plan is None:
        note(f"ct: {why_not}{' (to do it with what there is: --yes)' if result.missing else ''}")
    elif shown.form == PLAIN:
        _show_plans(result, shown)
    if plan is not None and why_not:
        note(f"ct: it can't be carried out: {why_not}")
    possible = plan is not None and not why_not
    if shown.form != PLAIN and not possible:
        _report(None, result, shown.form, None)
    return possible


def _show_plans(result: Result, shown: Shown) -> None:
    from corpus_tools.following.plan_steps import explained, sentence

    if result.missing:
        note(f"ct: there is no {' and no '.join(result.missing)} here")
    for number, plan in enumerate(result.plans, start=1):
        lead = f"{number}. " if len(result.plans) > 1 else ""
        say(f"{lead}{sentence(plan)}  (probability {plan.probability:.2f})")
        if plan.why_not and number > 1:
            say(f"  it can't be carried out: {plan.why_not}")
        is_asked = shown.asks and not (shown.yes or shown.plan_only or plan.why_not)
        if shown.search["explain"] or is_asked:
            say(*(f"  {line}" for line in explained(plan)))
    if result.note:
        note(f"ct: {result.note}")
    if result.question is not None:
        say(f"? {result.question.text}")


def _confirmed(result: Result, shown: Shown) -> bool:
    """Check that a plan is to be carried out: by the person's answer, else by its probability."""
    plan = result.plan
    if plan is None or shown.yes:
        return plan is not None
    if shown.asks:
        return click.confirm("Do this?", err=True)
    if plan.probability >= shown.confirm_below:
        return True
    from corpus_tools.following.plan_steps import as_record, sentence

    question = f"{sentence(plan)}: do this?"
    if shown.form != PLAIN:
        tell(shown.form, {**as_record(result, question), "execution": None})
    note(
        f"ct: {visible(question)} Its probability is {plan.probability:.2f}, less than "
        f"{shown.confirm_below:g}. To do it: --yes"
    )
    return False


def _report(done: Episode | None, result: Result, form: str, video: Path | None) -> None:
    """Print the result of a plan; programs get the plan with it."""
    from corpus_tools.following.plan_steps import as_record

    lines, execution = [], None
    if done is not None:
        seconds = float(done.recording.t_s[-1])
        files = [] if video is None else [video, video.with_suffix(".mcap")]
        execution = {"failure": done.failure, "seconds": round(seconds, 3), "files": files}
        if done.failure is not None:
            note(f"ct: the plan failed: {done.failure}")
        else:
            lines.append(f"done in {seconds:.0f} s of the world's time")
        if files:
            lines.append(f"wrote {files[0]} and {files[1]}")
    tell(form, {**as_record(result), "execution": execution}, *lines)


def _loop(grounder: Grounder, state: State, shown: Shown) -> None:
    """Follow commands until an empty one, each where the one before it has led."""
    from corpus_tools.following.plan_execution import checked

    while True:
        text = click.prompt("command", default="", show_default=False, err=True)
        if not text.strip():
            return
        result = checked(_asked(grounder, grounder.follow(text, state, **shown.search), shown))
        if _show(result, shown) and (shown.plan_only or _confirmed(result, shown)):
            state = _after(state, result, shown)


def _asked(grounder: Grounder, result: Result, shown: Shown) -> Result:
    """Ask a result's question, until an answer is understood: "2", "the left one" or "both"."""
    from g3.errors import AnswerError

    question = result.question
    if question is None:
        return result
    note(question.text)
    for number, (_, words) in enumerate(question.options, start=1):
        note(f"  {number}. {words}")
    while True:
        reply = click.prompt("which", err=True)
        try:
            return grounder.answer(result, reply, **shown.search)
        except AnswerError as unclear:
            note(f"ct: {unclear}")


def _after(state: State, result: Result, shown: Shown) -> State:
    from corpus_tools.following.plan_execution import run_plan

    assert result.plan is not None  # noqa: S101 - the caller has looked
    if shown.plan_only:
        _report(None, result, shown.form, None)
        return result.plan.state
    done = run_plan(state, result.plan.actions)
    _report(done, result, shown.form, None)
    return done.end
