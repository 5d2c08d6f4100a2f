"""Plans of a study: settings, plans kept one by one, executions, and pairs that people rate."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

import msgspec
import numpy as np
import yaml

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.following.plan_execution import PlanScript, run_plan, to_script
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Workers
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.video.items import ContextItem, Item
from corpus_tools.video.manifest import MANIFEST
from corpus_tools.video.manifest import Settings as VideoSettings
from corpus_tools.video.production import produce_all
from corpus_tools.world.scenarios.documents import read_document
from corpus_tools.world.state.recording import to_context
from eval.judging.execution import planned
from eval.judging.judge import Verdict, judge
from eval.judging.words_judge import judge_by_words
from eval.table_3.held_out import costs_without, data_of, parser_without
from eval.table_3.plan_rows import TOP
from g3.actions.robot_state import start_state
from g3.annotation import Annotation
from g3.errors import CorpusError, FormatError
from g3.groundings import Context
from g3.inference.grounder import Grounder, Plan
from g3.inference.problem.costs import RandomCost
from g3.storage.atomic_file import write_bytes

SETTINGS = "settings.json"


class Settings(msgspec.Struct, frozen=True):
    """Settings of a study; a folder holds one study only."""

    train: str
    """Names of the training corpora, with commas between; the tested scenario is held out."""
    test: str
    most: int
    """Number of commands of each scenario; 0 for all."""
    l2: float
    seed: int
    hashes: tuple[str, ...] = ()
    plans: tuple[str, ...] = ()
    """Verdicts of the plans in a rating set: ``wrong`` or ``right`` by the automatic judge, in
    order of priority; empty for a study like the paper's."""
    pairs: int = 0
    """Largest number of pairs in a rating set; 0 for all."""


def settings_for(
    train: str, test: str, *, most: int, l2: float, seed: int, plans: tuple[str, ...] = ()
) -> Settings:
    """Return settings with the hashes of the corpora.

    `most` is how many commands of each scenario, or how many pairs of a rating set; 0 for all.
    """
    hashes = tuple(open_corpus(name).hash for name in (*train.split(","), test))
    if plans:
        return Settings(train, test, 0, l2, seed, hashes, plans, most)
    return Settings(train, test, most, l2, seed, hashes)


def check_settings(folder: Path, settings: Settings) -> None:
    """Begin a study's folder; a FormatError if it is another study's, or holds other things."""
    path = folder / SETTINGS
    if not path.exists():
        if folder.exists() and any(folder.iterdir()):
            raise FormatError(
                "the folder holds other things", where=str(folder), fix="choose another name"
            )
        folder.mkdir(exist_ok=True)
        write_bytes(path, msgspec.json.format(msgspec.json.encode(settings)) + b"\n")
    elif msgspec.json.decode(path.read_bytes(), type=Settings) != settings:
        raise FormatError(
            "the folder is of another study: corpora or options differ",
            where=str(path),
            fix="give the same ones, or choose another folder",
        )


CONFIGURATIONS = ("random", "gold", "auto")
RATE_HZ = 10.0
"""Sampling rate of the objects in a run, in hertz; videos interpolate."""
PLANS, RUNS = "plans", "runs"
DIGITS = 3
"""Number of digits, in metres and degrees, to which the numbers of equal plans agree."""

Judge: TypeAlias = Callable[[Annotation, Plan], Verdict | None]

LOG, WORDS = "log", "words"
JUDGES: Mapping[str, Judge] = MappingProxyType(
    {
        LOG: lambda annotation, plan: judge(annotation.context, plan.state),
        WORDS: lambda annotation, plan: judge_by_words(
            annotation, planned(annotation.context, plan.actions)
        ),
    }
)
"""The automatic judge's verdicts by name, each on a command's plan."""


def script_digest(script: PlanScript) -> str:
    """Return a digest that is equal for plans with the same steps."""
    text = json.dumps(_rounded(msgspec.to_builtins(script)), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:10]


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
    """Verdicts by each of :data:`JUDGES` that can judge; empty if there is no plan."""

    @property
    def by_words(self) -> bool | None:
        """The verdict by words: False without a plan, None if there is none."""
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
    configured = [r for r in records if r.configuration == configuration]
    return sorted(configured, key=lambda r: (-r.probability, r.command))[:TOP]


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
    corpora = [open_corpus(name) for name in settings.train.split(",")]
    data = data_of(corpora, seed=settings.seed, on_progress=on_progress)
    cost_of, parser_of = costs_without(data, l2=settings.l2), parser_without(corpora)
    for unit in units:
        annotation, sdcs = unit.annotation, unit.annotation.sdcs
        scenario = annotation.command.scenario
        if unit.configuration == "auto":
            [sdcs] = parser_of(scenario).predict([annotation.command.text])
        is_random = unit.configuration == "random"
        grounder = Grounder(RandomCost(settings.seed) if is_random else cost_of(scenario))
        result = grounder.follow(sdcs, annotation.context, least=0.0, insist=True)
        yield unit, result.plan, result.note


def _record(unit: Unit, plan: Plan | None, note: str) -> PlanRecord:
    command = unit.annotation.command
    about = (unit.configuration, command.id, command.scenario, command.text)
    if plan is None:
        return PlanRecord(*about, 0.0, False, note)
    verdict = judge(unit.annotation.context, plan.state)
    verdicts = {name: decide(unit.annotation, plan) for name, decide in JUDGES.items()}
    return PlanRecord(
        *about,
        plan.probability,
        verdict.correct,
        verdict.reason,
        script=to_script(start_state(unit.annotation.context), plan.actions),
        verdicts={name: v.correct for name, v in verdicts.items() if v},
    )


def carry_out(folder: Path, run: str, record: PlanRecord, context: Context) -> str:
    """Carry out a plan in physics and write its run; return why it stopped, or ""."""
    if record.script is None:
        raise ValueError(f"there is no plan for {record.command}")
    done = run_plan(start_state(context), record.script, rate_hz=RATE_HZ)
    corpus = Corpus.build(
        run,
        contexts=[replace(to_context(done.recording), id=run)],
        commands=[],
        annotations=[],
        source=f"a plan for {record.command}, carried out in physics",
    )
    corpus.save(run_corpus(folder, run), force=True)
    return "" if done.failure is None else str(done.failure)


STUDY, VIDEOS = "study.yaml", "videos"
HOW = VideoSettings(fps=15, quality="draft")
INSTANCE = "annotation"
"""The annotation app's folder in the study's."""
ANSWERS = 5
"""Number of judgments of each pair, as in the paper."""

HEAD = """\
# A rating study of plans, as in section 4.3 of the paper. Written by ct eval end-to-end.
# In this folder: ct annotate study.yaml --instance annotation
# ct eval end-to-end reads what people have rated there. Change what you like but for the pairs.
"""


@dataclass(frozen=True, slots=True)
class Pair:
    """A command with a video."""

    text: str
    video: str
    """Name of the run, or of the test corpus's context with the log shown."""
    own_video: str
    """Name of the context that the command was typed for."""
    configuration: str
    """``random``, ``gold`` or ``auto`` for a plan; ``right`` or ``wrong`` for a known pair."""
    command: str

    @property
    def key(self) -> tuple[str, str, str]:
        """Key of the pair, as in :func:`eval.statistics.ratings.shown_pair`."""
        return self.text, self.own_video, self.video

    @property
    def is_plan(self) -> bool:
        """True if the video shows a plan."""
        return self.configuration not in ("right", "wrong")


def pairs(records: list[PlanRecord], commands: list[Annotation], seed: int) -> list[Pair]:
    """Return all pairs to rate.

    Of extracted clauses only the most probable plans are shown, as in the paper. One command of
    each scenario is shown with its own video, and with a random other one of the test corpus. This
    shows whether people distinguish right from wrong.
    """
    contexts = {a.command.id: a.context.id for a in commands}
    best = {r.command for r in top(records, "auto")}
    result = [
        Pair(r.text, r.run, contexts[r.command], r.configuration, r.command)
        for r in records
        if r.run and (r.configuration != "auto" or r.command in best)
    ]
    rng = np.random.default_rng(seed)
    by_scenario: dict[str, list[Annotation]] = {}
    for annotation in commands:
        by_scenario.setdefault(annotation.command.scenario, []).append(annotation)
    for several in by_scenario.values():
        chosen = several[int(rng.integers(len(several)))]
        text, mine = chosen.command.text, chosen.context.id
        result.append(Pair(text, mine, mine, "right", chosen.command.id))
        others = sorted({video for video in contexts.values() if video != mine})
        if others:
            other = others[int(rng.integers(len(others)))]
            result.append(Pair(text, other, mine, "wrong", chosen.command.id))
    return result


def write_study(folder: Path, pairs: list[Pair], seed: int, pay: float | None = None) -> Path:
    """Write the study's file for ``ct annotate``; its pairs don't show their origin.

    Edits of the file are kept, except to the pairs, and to the pay for each in dollars if it is
    given here.
    """
    path = folder / STUDY
    study: dict[str, object] = {
        "name": "plans",
        "title": "What is the forklift doing?",
        "videos": VIDEOS,
        "tasks": {"rate": {"answers": ANSWERS, "lease_minutes": 20, "practice": True}},
        "seed": seed,
    }
    written = read_document(path).value if path.exists() else None
    if isinstance(written, dict):
        study |= written
    if pay is not None:
        study["payment"] = {"amount": pay, "currency": "USD"}
    study["pairs"] = [
        {"text": pair.text, "video": pair.video, "own_video": pair.own_video} for pair in pairs
    ]
    text = yaml.safe_dump(study, sort_keys=False, allow_unicode=True, width=100)
    write_bytes(path, (HEAD + text).encode())
    return path


def film_all(
    folder: Path, test: str, pairs: list[Pair], on_progress: OnProgress = no_progress
) -> None:
    """Make the videos of all pairs that aren't there yet; a CorpusError if one can't be made."""
    by_video = {pair.video: pair for pair in pairs}
    items: list[Item] = [
        ContextItem(video, str(run_corpus(folder, video)) if pair.is_plan else test, video)
        for video, pair in sorted(by_video.items())
        if not (folder / VIDEOS / video / MANIFEST).exists()
    ]
    if not items:
        return
    (folder / VIDEOS).mkdir(exist_ok=True)
    workers = Workers(min(os.cpu_count() or 1, len(items)))
    before = len(by_video) - len(items)
    outcomes = produce_all(items, folder / VIDEOS, HOW, workers=workers, force=False)
    for number, outcome in enumerate(outcomes, before + 1):
        if outcome.problem:
            raise CorpusError(outcome.problem, where=f"the video {outcome.name}")
        on_progress(f"videos: {outcome.name}", number, len(by_video))
