"""Counting what is in a corpus, for comparison with section 4.1 of the paper."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import msgspec

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.task_outcomes import is_drive, outcomes_of
from g3.annotation import SOURCES, UNKNOWNS, Annotation, TaskOutcome, Unknown
from g3.sdc.clauses import SDC, SDC_TYPES, breadth_first
from g3.short_repr import short_repr

PAPER = {"subjects": 45.0, "videos": 22.0, "commands_per_video": 13.0}
"""What section 4.1 says of the corpus of AAAI-11."""


class Examples(msgspec.Struct, frozen=True):
    """Clauses that are grounded and labelled, by label."""

    true: int
    false: int


@short_repr
class Statistics(msgspec.Struct, frozen=True):
    """What is in a corpus.

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


def statistics(corpus: Corpus) -> Statistics:
    """Count what is in a corpus."""
    positives = [a for a in corpus.annotations if a.source == "positive"]
    commands = {a.command.id: a.command for a in positives}.values()
    videos = {command.video for command in commands if command.video}
    clauses = [sdc for a in positives for sdc in breadth_first(a.sdcs)]
    same = sum(j.command_video == j.shown_video for j in corpus.judgments)
    return Statistics(
        name=corpus.name,
        hash=corpus.hash,
        videos=len(videos),
        subjects=len({command.subject for command in commands if command.subject}),
        commands=len(commands),
        commands_typed=len(corpus.commands),
        commands_per_video=len(commands) / len(videos) if videos else 0.0,
        sdcs=len(clauses),
        sdcs_by_type=_by_type(clauses),
        implicit=sum(sdc.is_implicit for sdc in clauses),
        annotations=dict(Counter(a.source for a in corpus.annotations)),
        examples_by_source={
            source: _examples([a for a in corpus.annotations if a.source == source])
            for source in SOURCES
        },
        contexts=len(corpus.contexts),
        judgments=len(corpus.judgments),
        judgments_same=same,
        judgments_different=len(corpus.judgments) - same,
        scenarios=tuple(sorted({command.scenario for command in corpus.commands.values()})),
        outcomes=_outcomes(corpus),
    )


def _outcomes(corpus: Corpus) -> dict[str, int]:
    found = corpus.outcomes
    if not found:
        return {}
    return {
        "tasks": len(found),
        "commands": sum(bool(outcomes_of(corpus, c)) for c in corpus.commands.values()),
        "driven only": sum(is_drive(o) for o in found),
        "held": sum(o.put == "held" for o in found),
        "put on something": sum(o.put == "on" for o in found),
        "put on the ground": sum(o.put == "ground" for o in found),
        **{f"unknown: {name}": n for name in UNKNOWNS if (n := _unknown(found, name))},
    }


def _unknown(outcomes: Sequence[TaskOutcome], what: Unknown) -> int:
    return sum(what in outcome.unknown for outcome in outcomes)


def _by_type(clauses: list[SDC]) -> dict[str, int]:
    counts = Counter(sdc.type for sdc in clauses)
    return {name: counts[name] for name in SDC_TYPES}


def _examples(annotations: list[Annotation]) -> Examples:
    labels = [
        label
        for annotation in annotations
        for label, groundings in zip(annotation.correct, annotation.groundings, strict=True)
        if groundings
    ]
    return Examples(true=labels.count(True), false=labels.count(False))
