"""Counts of a corpus's files, line by line: memory doesn't grow with annotations.

Only files that are byte by byte what a program wrote are counted so, which the digests of
corpus.json show: then nothing else about them need be checked.
"""

from __future__ import annotations

import errno
import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.corpus import corpus_records as records
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_statistics import Statistics, Tally, of_annotations, statistics
from corpus_tools.corpus.corpus_tables import is_as_written
from corpus_tools.corpus.decoding import command, read_manifest
from corpus_tools.corpus.trajectory_arrays import read_arrays
from g3.annotation import Command
from g3.storage import regular_file
from g3.storage.system_errors import about

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
    found = {name: _each_line(folder / name, count) for name, count in counting.items()}
    if not is_as_written(manifest, found, read_arrays(folder / records.TRAJECTORIES)):
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
