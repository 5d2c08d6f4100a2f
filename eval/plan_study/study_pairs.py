"""Pairs of commands and videos to rate: plans, and known right and wrong pairs."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from corpus_tools.runtime.parallel import Workers
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.video.items import ContextItem, Item
from corpus_tools.video.manifest import MANIFEST, Settings
from corpus_tools.video.render_batch import produce_all
from corpus_tools.world.scenarios.documents import read_document
from eval.plan_study.study_plans import PlanRecord, run_corpus, top
from g3.annotation import Annotation
from g3.errors import CorpusError
from g3.storage.atomic_file import write_bytes

STUDY, VIDEOS = "study.yaml", "videos"
HOW = Settings(fps=15, quality="draft")
INSTANCE = "annotation"
"""The annotation app's folder in the study's."""
ANSWERS = 5
"""Number of judgments of each pair, as in the paper."""

HEAD = """\
# A rating study of plans, as in section 4.3 of the paper. Written by ct eval --end-to-end.
# In this folder: ct annotate study.yaml --instance annotation
# ct eval --end-to-end reads what people have rated there. Change what you like but for the pairs.
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
    own = {a.command.id: a.context.id for a in commands}
    best = {r.command for r in top(records, "auto")}
    found = [
        Pair(r.text, r.run, own[r.command], r.configuration, r.command)
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
        found.append(Pair(text, mine, mine, "right", chosen.command.id))
        others = sorted({video for video in own.values() if video != mine})
        if others:
            other = others[int(rng.integers(len(others)))]
            found.append(Pair(text, other, mine, "wrong", chosen.command.id))
    return found


def write_study(folder: Path, found: list[Pair], seed: int, pay: float | None = None) -> Path:
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
    known = read_document(path).value if path.exists() else None
    if isinstance(known, dict):
        study |= known
    if pay is not None:
        study["payment"] = {"amount": pay, "currency": "USD"}
    study["pairs"] = [
        {"text": pair.text, "video": pair.video, "own_video": pair.own_video} for pair in found
    ]
    text = yaml.safe_dump(study, sort_keys=False, allow_unicode=True, width=100)
    write_bytes(path, (HEAD + text).encode())
    return path


def film_all(
    folder: Path, test: str, pairs: list[Pair], on_progress: OnProgress = no_progress
) -> None:
    """Make the videos of all pairs that aren't there yet; a CorpusError if one can't be made."""
    wanted = {pair.video: pair for pair in pairs}
    items: list[Item] = [
        ContextItem(video, str(run_corpus(folder, video)) if pair.is_plan else test, video)
        for video, pair in sorted(wanted.items())
        if not (folder / VIDEOS / video / MANIFEST).exists()
    ]
    if not items:
        return
    (folder / VIDEOS).mkdir(exist_ok=True)
    workers = Workers(min(os.cpu_count() or 1, len(items)))
    before = len(wanted) - len(items)
    outcomes = produce_all(items, folder / VIDEOS, HOW, workers=workers, force=False)
    for number, outcome in enumerate(outcomes, before + 1):
        if outcome.problem:
            raise CorpusError(outcome.problem, where=f"the video {outcome.name}")
        on_progress(f"videos: {outcome.name}", number, len(wanted))
