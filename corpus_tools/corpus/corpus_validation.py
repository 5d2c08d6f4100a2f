"""Checks of everything in a corpus, and acceptance of changes made by hand."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from corpus_tools.corpus import corpus_records as records
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_tables import manifest_to_bytes, read_arrays, sealed, unpack_one
from corpus_tools.corpus.decoding import read_content, read_manifest, refuse
from g3.errors import CorpusError, FormatError
from g3.groundings import FloatArray, PhysicalObject, Place, Prism
from g3.sdc.sdc_notation import check_sdc
from g3.storage.atomic_file import write_bytes

SMALLEST_AREA_M2 = 1e-6


def validate(folder: Path) -> list[CorpusError]:
    """Everything that is wrong with a corpus, in the order of its files.

    Beyond what loading checks: that SDCs are well formed, that footprints have an area, that every
    stored trajectory can be read, and that people's ratings and commands have their texts and
    videos. A folder that isn't a corpus, or a whole file that is missing or can't be read, is a
    FormatError.
    """
    problems: list[CorpusError] = []
    corpus = Corpus.load(folder, on_problem=problems.append)
    problems += _trajectory_problems(folder)
    problems += _prism_problems(corpus, folder)
    problems += _text_problems(corpus, folder)
    problems += _sdc_problems(corpus, folder)
    unique = {str(problem): problem for problem in problems}
    return list(unique.values())


def _trajectory_problems(folder: Path) -> Iterator[CorpusError]:
    arrays = read_arrays(folder / records.TRAJECTORIES)
    for index in range(len(arrays["offsets"]) - 1):
        try:
            unpack_one(arrays, index)
        except FormatError as problem:
            yield FormatError(problem.what, where=f"{folder / problem.where}", fix=problem.fix)


def _prism_problems(corpus: Corpus, folder: Path) -> Iterator[CorpusError]:
    for where, prism in _prisms(corpus, folder):
        if abs(_signed_area(prism.xy)) < SMALLEST_AREA_M2:
            yield FormatError(
                "the footprint has no area", where=f"{where}: prism.xy", fix="correct its corners"
            )


def _prisms(corpus: Corpus, folder: Path) -> Iterator[tuple[str, Prism]]:
    for context in corpus.contexts.values():
        where = f"{folder / records.CONTEXTS}: {context.id}"
        for item in context.objects:
            yield f"{where}: object {item.id}", item.prism
        for i, place in enumerate(context.places):
            yield f"{where}: places[{i}]", place.prism
    for annotation in corpus.annotations:
        shared = set(map(id, annotation.context.objects))
        where = f"{folder / records.ANNOTATIONS}: {annotation.id}"
        for i, groundings in enumerate(annotation.groundings):
            for grounding in groundings:
                if isinstance(grounding, PhysicalObject | Place) and id(grounding) not in shared:
                    yield f"{where}: groundings[{i}]", grounding.prism


def _signed_area(xy: FloatArray) -> float:
    x, y = (xy - xy[0]).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def _text_problems(corpus: Corpus, folder: Path) -> Iterator[CorpusError]:
    for annotation in corpus.annotations:
        if not annotation.command.text.strip():
            yield FormatError(
                f"{annotation.id} annotates a command without text",
                where=f"{folder / records.COMMANDS}: {annotation.command.id}: text",
                fix="add the text, or remove the annotation",
            )
    for judgment in corpus.judgments:
        for field in ("command", "command_video", "shown_video"):
            if not getattr(judgment, field).strip():
                yield FormatError(
                    "the value is empty",
                    where=f"{folder / records.JUDGMENTS}: {judgment.id}: {field}",
                    fix="add it, or remove the judgment",
                )


def _sdc_problems(corpus: Corpus, folder: Path) -> Iterator[CorpusError]:
    for annotation in corpus.annotations:
        for i, sdc in enumerate(annotation.sdcs):
            try:
                check_sdc(sdc, where=f"{folder / records.ANNOTATIONS}: {annotation.id}: sdcs[{i}]")
            except CorpusError as problem:
                yield problem


def seal(folder: Path) -> tuple[records.Manifest, records.Manifest]:
    """Write the hash, counts and digests of a corpus's present content into its corpus.json.

    Returns the manifest as it was, and as it is now. If anything else is wrong with the corpus,
    that is a FormatError, and nothing is written.
    """
    before = read_manifest(folder)
    _, tables = read_content(folder, before, refuse)
    after = sealed(before, tables)
    write_bytes(folder / records.MANIFEST, manifest_to_bytes(after))
    return before, after
