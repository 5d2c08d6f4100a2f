"""Counts of a corpus, for comparison with section 4.1 of the paper."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import msgspec

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_records import SDCRecord
from corpus_tools.corpus.task_outcomes import is_drive, outcomes_of
from g3.annotation import SOURCES, UNKNOWNS, Command
from g3.sdc.clauses import SDC, SDC_TYPES, breadth_first
from g3.short_repr import short_repr

PAPER = {"subjects": 45.0, "videos": 22.0, "commands_per_video": 13.0}
"""Figures of the corpus in section 4.1 of AAAI-11."""


class Examples(msgspec.Struct, frozen=True):
    """Clauses that are grounded and labelled, by label."""

    true: int
    false: int


@short_repr
class Statistics(msgspec.Struct, frozen=True):
    """Counts and lengths of a corpus.

    Videos, subjects, commands and SDCs are those of the commands that have a positive
    annotation. ``sdcs`` and ``sdcs_by_type`` count every clause of the positive
    annotations, the implicit figures (the unnamed robot of an imperative) among them;
    ``implicit`` says how many of the OBJECTs those are. ``outcomes`` counts what is known of
    tasks; it is empty where there is no task.
    """

    name: str
    hash: str
    videos: int
    subjects: int
    commands: int
    commands_typed: int
    commands_per_video: float
    sdcs: int
    sdcs_by_type: dict[str, int]
    implicit: int
    annotations: dict[str, int]
    examples_by_source: dict[str, Examples]
    contexts: int
    judgments: int
    judgments_same: int
    judgments_different: int
    scenarios: tuple[str, ...]
    outcomes: dict[str, int]


class Tally:
    """Counts annotations one by one, so that a corpus needn't be in memory."""

    def __init__(self) -> None:
        self.sources: Counter[str] = Counter()
        self.clauses: Counter[str] = Counter()
        self.implicit = 0
        self.labels: Counter[tuple[str, bool]] = Counter()
        self.commands: set[str] = set()
        """Ids of the commands that have a positive annotation."""

    def add(
        self,
        source: str,
        command: str,
        clauses: Iterable[SDC | SDCRecord],
        labels: Iterable[tuple[bool | None, Sequence[object]]],
    ) -> None:
        """Count an annotation.

        `clauses` are those of all of its trees; `labels` has for each clause whether its groundings
        are right, and the groundings.
        """
        self.sources[source] += 1
        self.labels.update(
            (source, label) for label, groundings in labels if groundings and label is not None
        )
        if source != "positive":
            return
        self.commands.add(command)
        for sdc in clauses:
            self.clauses[sdc.type] += 1
            self.implicit += is_implicit(sdc)


def statistics(corpus: Corpus) -> Statistics:
    """Count the content of a corpus."""
    tally = Tally()
    for a in corpus.annotations:
        labels = zip(a.correct, a.groundings, strict=True)
        tally.add(a.source, a.command.id, breadth_first(a.sdcs), labels)
    same = sum(j.command_video == j.shown_video for j in corpus.judgments)
    return Statistics(
        name=corpus.name,
        hash=corpus.hash,
        contexts=len(corpus.contexts),
        judgments=len(corpus.judgments),
        judgments_same=same,
        judgments_different=len(corpus.judgments) - same,
        outcomes=_outcomes(corpus),
        **of_annotations(tally, corpus.commands.values()),
    )


def of_annotations(tally: Tally, commands: Iterable[Command]) -> dict[str, Any]:
    """Return the fields of `Statistics` that depend on commands and their annotations."""
    typed, videos, subjects, scenarios = 0, set(), set(), set()
    for command in commands:
        typed += 1
        scenarios.add(command.scenario)
        if command.id in tally.commands:
            videos.add(command.video)
            subjects.add(command.subject)
    videos.discard("")
    subjects.discard("")
    return {
        "videos": len(videos),
        "subjects": len(subjects),
        "commands": len(tally.commands),
        "commands_typed": typed,
        "commands_per_video": len(tally.commands) / len(videos) if videos else 0.0,
        "sdcs": tally.clauses.total(),
        "sdcs_by_type": {name: tally.clauses[name] for name in SDC_TYPES},
        "implicit": tally.implicit,
        "annotations": dict(tally.sources),
        "examples_by_source": {
            source: Examples(true=tally.labels[source, True], false=tally.labels[source, False])
            for source in SOURCES
        },
        "scenarios": tuple(sorted(scenarios)),
    }


def is_implicit(sdc: SDC | SDCRecord) -> bool:
    """Check that a clause has no words: the robot that an imperative doesn't name."""
    return not any((sdc.words, sdc.relation, sdc.figure, sdc.landmark1, sdc.landmark2))


def _outcomes(corpus: Corpus) -> dict[str, int]:
    found = corpus.outcomes
    if not found:
        return {}
    unknown = Counter(what for outcome in found for what in {*outcome.unknown})
    return {
        "tasks": len(found),
        "commands": sum(bool(outcomes_of(corpus, c)) for c in corpus.commands.values()),
        "driven only": sum(is_drive(o) for o in found),
        "held": sum(o.put == "held" for o in found),
        "put on something": sum(o.put == "on" for o in found),
        "put on the ground": sum(o.put == "ground" for o in found),
        **{f"unknown: {what}": unknown[what] for what in UNKNOWNS if unknown[what]},
    }
