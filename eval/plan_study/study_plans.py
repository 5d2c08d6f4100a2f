"""Plans for held-out commands, kept one by one, and their executions."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

import msgspec
import numpy as np

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.corpus.corpus_writing import write_corpus
from corpus_tools.corpus.encoding import make_corpus
from corpus_tools.following.bundled_grounder import to_script
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.world.physics.execute import execute
from corpus_tools.world.state.recording import to_context
from corpus_tools.world.state.robot_script import Script
from eval.judging.execution import planned
from eval.judging.judge import Verdict, judge
from eval.judging.words_judge import judge_by_words
from eval.plan_study.study_settings import Settings
from eval.table_3.held_out import costs_without, extractor_without
from eval.table_3.plan_rows import TOP
from eval.table_3.search_examples import data_of
from g3.actions.action_kinds import Action
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.groundings import Context, Place, Prism
from g3.inference.grounder import Grounder, Plan
from g3.inference.problem.costs import RandomCost
from g3.storage.atomic_file import write_bytes

CONFIGURATIONS = ("random", "gold", "auto")
RATE_HZ = 10.0
"""Sampling rate of the objects in a run, in hertz; videos interpolate."""
PLANS, RUNS = "plans", "runs"
DIGITS = 3
"""Number of digits, in metres and degrees, to which the numbers of equal plans agree."""

Judge: TypeAlias = Callable[[Annotation, Plan], Verdict]

WORDS = "words"
JUDGES: Mapping[str, Judge] = MappingProxyType(
    {
        "log": lambda annotation, plan: judge(annotation.context, plan.state),
        WORDS: lambda annotation, plan: judge_by_words(
            annotation, planned(annotation.context, plan.actions)
        ),
    }
)
"""The automatic judge's verdicts by name, each on a command's plan. The first one counts."""
FIRST = next(iter(JUDGES))


class KeptPlace(msgspec.Struct, frozen=True):
    """A place that a script names: corners in metres, heights of bottom and top."""

    xy: tuple[tuple[float, float], ...]
    z_min: float
    z_max: float
    name: str = ""


class PlanScript(msgspec.Struct, frozen=True):
    """A plan as a script: steps, and the places that these name."""

    steps: Script
    kept_places: dict[str, KeptPlace] = {}

    @property
    def places(self) -> dict[str, Place]:
        """The places by their names, as :func:`~corpus_tools.world.physics.execute` takes them."""
        return {
            key: Place(Prism(np.array(p.xy), p.z_min, p.z_max), p.name)
            for key, p in self.kept_places.items()
        }

    @property
    def digest(self) -> str:
        """A digest that is equal for plans with the same steps."""
        text = json.dumps(_rounded(msgspec.to_builtins(self)), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:10]


def script_of(start: State, actions: tuple[Action, ...]) -> PlanScript:
    """Write a plan as a script."""
    told = to_script(start, actions)
    places = {
        key: KeptPlace(
            tuple((float(x), float(y)) for x, y in place.prism.xy),
            float(place.prism.z_min),
            float(place.prism.z_max),
            place.name,
        )
        for key, place in told.places.items()
    }
    return PlanScript(told.script, places)


class PlanRecord(msgspec.Struct, frozen=True):
    """A plan as kept in a study's folder."""

    configuration: str
    command: str
    scenario: str
    text: str
    probability: float
    correct: bool
    reason: str
    """The automatic judge's first verdict: agreement with the log's end."""
    run: str = ""
    """Name of the run that executed the plan; empty if there is no plan."""
    failure: str = ""
    """Reason for which physics stopped the run; empty if it didn't."""
    script: PlanScript | None = None
    """The robot's script; None if there is no plan."""
    verdicts: dict[str, bool] = {}
    """Verdicts by each of :data:`JUDGES`; empty if there is no plan."""

    @property
    def by_words(self) -> bool | None:
        """The verdict by words: False without a plan, None in older studies."""
        return self.verdicts.get(WORDS) if self.script or self.run else False


def _rounded(value: object) -> object:
    if isinstance(value, float):
        return round(value, DIGITS) + 0.0  # -0.0 is 0.0
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    return value


@dataclass(frozen=True, slots=True)
class Unit:
    """A command in a configuration."""

    configuration: str
    annotation: Annotation

    @property
    def name(self) -> str:
        """Name of its files, without a suffix."""
        return f"{self.configuration}-{self.annotation.command.id}".replace("/", "-")


def chosen_commands(settings: Settings) -> list[Annotation]:
    """Return the commands to follow, by scenario."""
    by_scenario: dict[str, list[Annotation]] = {}
    for annotation in annotated_commands(open_corpus(settings.test).annotations).values():
        by_scenario.setdefault(annotation.command.scenario, []).append(annotation)
    most = settings.most or None
    return [a for name in sorted(by_scenario) for a in by_scenario[name][:most]]


def plan_all(
    folder: Path, settings: Settings, on_progress: OnProgress = no_progress
) -> list[PlanRecord]:
    """Make the missing plans, carry them out, and return all plans.

    Each is kept as soon as it is made. For a rating set only a sample is carried out, later.
    """
    for name in (PLANS, RUNS):
        (folder / name).mkdir(exist_ok=True)
    commands = chosen_commands(settings)
    units = [Unit(which, a) for a in commands for which in CONFIGURATIONS]
    todo = [unit for unit in units if not _kept(folder, unit).exists()]
    done = len(units) - len(todo)

    def learning(step: str, _done: int, _total: int) -> None:  # without moving the bar
        on_progress(step, done, len(units))

    for number, (unit, plan, note) in enumerate(_planned(todo, settings, learning), done + 1):
        record = _record(unit, plan, note)
        if not settings.plans and record.script is not None:
            failure = carry_out(folder, unit.name, record, unit.annotation.context)
            record = msgspec.structs.replace(record, run=unit.name, failure=failure)
        write_bytes(_kept(folder, unit), msgspec.json.encode(record))
        on_progress(f"plans and runs: {unit.name}", number, len(units))
    return [msgspec.json.decode(_kept(folder, u).read_bytes(), type=PlanRecord) for u in units]


def top(records: list[PlanRecord], configuration: str) -> list[PlanRecord]:
    """Return a configuration's most probable plans, as many as the paper's top rows have."""
    own = [r for r in records if r.configuration == configuration]
    return sorted(own, key=lambda r: (-r.probability, r.command))[:TOP]


def run_corpus(folder: Path, run: str) -> Path:
    """Return the folder of the corpus that holds a run as its only context."""
    return folder / RUNS / run


def _kept(folder: Path, unit: Unit) -> Path:
    return folder / PLANS / f"{unit.name}.json"


def _planned(
    units: list[Unit], settings: Settings, on_progress: OnProgress
) -> Iterator[tuple[Unit, Plan | None, str]]:
    """Yield the best plan of each unit; its scenario is held out of training."""
    if not units:
        return
    known = [open_corpus(name) for name in settings.train.split(",")]
    data = data_of(known, seed=settings.seed, on_progress=on_progress)
    cost_of, extractor_of = costs_without(data, l2=settings.l2), extractor_without(known)
    for unit in units:
        annotation, sdcs = unit.annotation, unit.annotation.sdcs
        scenario = annotation.command.scenario
        if unit.configuration == "auto":
            [sdcs] = extractor_of(scenario).predict([annotation.command.text])
        is_random = unit.configuration == "random"
        grounder = Grounder(RandomCost(settings.seed) if is_random else cost_of(scenario))
        result = grounder.follow(sdcs, annotation.context, least=0.0, insist=True)
        yield unit, result.plan, result.note


def _record(unit: Unit, plan: Plan | None, note: str) -> PlanRecord:
    command = unit.annotation.command
    about = (unit.configuration, command.id, command.scenario, command.text)
    if plan is None:
        return PlanRecord(*about, 0.0, False, note)
    said = {name: decide(unit.annotation, plan) for name, decide in JUDGES.items()}
    return PlanRecord(
        *about,
        plan.probability,
        said[FIRST].correct,
        said[FIRST].reason,
        script=script_of(start_state(unit.annotation.context), plan.actions),
        verdicts={name: verdict.correct for name, verdict in said.items()},
    )


def carry_out(folder: Path, run: str, record: PlanRecord, context: Context) -> str:
    """Carry out a plan in physics and write its run; return why it stopped, or ""."""
    if record.script is None:
        raise ValueError(f"there is no plan for {record.command}")
    script = record.script
    done = execute(context, script.steps, places=script.places, rate_hz=RATE_HZ)
    corpus = make_corpus(
        run,
        contexts=[replace(to_context(done.recording), id=run)],
        commands=[],
        annotations=[],
        source=f"a plan for {record.command}, carried out in physics",
    )
    write_corpus(corpus, run_corpus(folder, run), force=True)
    return "" if done.failure is None else str(done.failure)
