"""Counts of a corpus, for comparison with section 4.1 of the paper.

A corpus's files are counted line by line, so that memory doesn't grow with annotations, where they
are byte by byte what a program wrote. Their digests in corpus.json show that: then nothing else
about them need be checked.
"""

from __future__ import annotations

import errno
import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.corpus import corpus_records as records
from corpus_tools.corpus.corpus_model import INVENTED, Corpus
from corpus_tools.corpus.corpus_records import SDCRecord
from corpus_tools.corpus.corpus_tables import is_as_written, read_arrays
from corpus_tools.corpus.decoding import command, read_manifest
from corpus_tools.corpus.task_outcomes import is_drive, outcomes_of
from g3.annotation import SOURCES, UNKNOWNS, Command
from g3.sdc.clauses import SDC, SDC_TYPES, breadth_first
from g3.short_repr import short_repr
from g3.storage import regular_file
from g3.storage.system_errors import about

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
    is_authored: bool
    """True if authors or a program wrote all commands; the paper's counts aren't beside then."""


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
    is_authored = True
    for each in commands:
        typed += 1
        is_authored &= each.subject.startswith(INVENTED)
        scenarios.add(each.scenario)
        if each.id in tally.commands:
            videos.add(each.video)
            subjects.add(each.subject)
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
        "is_authored": is_authored and typed > 0,
    }


def is_implicit(sdc: SDC | SDCRecord) -> bool:
    """Check that a clause has no words: the robot that an imperative doesn't name."""
    return not any((sdc.words, sdc.relation, sdc.figure, sdc.landmark1, sdc.landmark2))


def _outcomes(corpus: Corpus) -> dict[str, int]:
    outcomes = corpus.outcomes
    if not outcomes:
        return {}
    unknown = Counter(what for outcome in outcomes for what in {*outcome.unknown})
    return {
        "tasks": len(outcomes),
        "commands": sum(bool(outcomes_of(corpus, c)) for c in corpus.commands.values()),
        "driven only": sum(is_drive(o) for o in outcomes),
        "held": sum(o.put == "held" for o in outcomes),
        "put on something": sum(o.put == "on" for o in outcomes),
        "put on the ground": sum(o.put == "ground" for o in outcomes),
        **{f"unknown: {what}": unknown[what] for what in UNKNOWNS if unknown[what]},
    }


LONGEST_LINE = 1 << 26
"""Largest number of a line's bytes that are held in memory."""


def statistics_of_files(folder: Path) -> Statistics:
    """Count a corpus like :func:`~corpus_tools.corpus.corpus_statistics.statistics`.

    Raises FormatError if something is wrong with the corpus.
    """
    manifest = read_manifest(folder)
    if not manifest.counts.outcomes:
        try:
            counted = _counted(folder, manifest)
        except (OSError, msgspec.DecodeError, UnicodeDecodeError, RecursionError):
            counted = None
        if counted is not None:
            return counted
    return statistics(Corpus.load(folder))  # or it tells what is wrong


def _counted(folder: Path, manifest: records.Manifest) -> Statistics | None:
    """Count the files; None if they differ from those that were written."""
    tally, commands, same = Tally(), list[Command](), 0

    def count_annotation(line: bytes) -> None:
        record = annotations.decode(line)
        labels = zip(record.correct, record.groundings, strict=True)
        tally.add(record.source, record.command, _all_clauses(record), labels)

    def count_judgment(line: bytes) -> None:
        nonlocal same
        record = judgments.decode(line)
        same += record.command_video == record.shown_video

    annotations = msgspec.json.Decoder(records.AnnotationRecord)
    judgments = msgspec.json.Decoder(records.JudgmentRecord)
    typed = msgspec.json.Decoder(records.CommandRecord)
    counting: dict[str, Callable[[bytes], Any]] = {
        records.CONTEXTS: lambda _line: None,
        records.COMMANDS: lambda line: commands.append(command(typed.decode(line))),
        records.ANNOTATIONS: count_annotation,
        records.JUDGMENTS: count_judgment,
    }
    by_file = {name: _each_line(folder / name, count) for name, count in counting.items()}
    if not is_as_written(manifest, by_file, read_arrays(folder / records.TRAJECTORIES)):
        return None
    return Statistics(
        name=manifest.name,
        hash=manifest.hash,
        contexts=manifest.counts.contexts,
        judgments=manifest.counts.judgments,
        judgments_same=same,
        judgments_different=manifest.counts.judgments - same,
        outcomes={},
        **of_annotations(tally, commands),
    )


def _each_line(path: Path, count: Callable[[bytes], Any]) -> str:
    """Hand each line of a file on; the digest of all of them."""
    digest = hashlib.sha256()
    with about(path), regular_file.opened(path) as file:
        while line := file.readline(LONGEST_LINE):
            if len(line) == LONGEST_LINE:
                raise OSError(errno.EFBIG, "a line is longer than any of a corpus")
            digest.update(line)
            count(line)
    return f"sha256:{digest.hexdigest()}"


def _all_clauses(record: records.AnnotationRecord) -> Iterator[records.SDCRecord]:
    pending = [*record.sdcs]
    while pending:
        sdc = pending.pop()
        yield sdc
        pending += (*sdc.figure, *sdc.landmark1, *sdc.landmark2)
