"""Predictions by other programs, read from a file: rows of Table 1 beside G³."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np

from corpus_tools.corpus.answer_records import PredictionLine, write_lines
from corpus_tools.tables.json_text import json_lines
from eval.statistics.comparison import Comparison
from eval.statistics.estimates import FloatArray
from eval.table_1.correspondence import ROW_TYPES, Predictions, RowType, predicted_true
from eval.tables.comparison_report import compare_commands
from g3.errors import FormatError
from g3.features.factor_batch import ROLES
from g3.geometry.footprints import centre
from g3.groundings import Grounding, PhysicalObject
from g3.groundings import Path as Way
from g3.learning.examples import Example
from g3.sdc.clauses import all_words

OURS = "g3"
"""Name of the model beside others."""
FIX = "`ct eval table1 --write-tasks FILE` writes the form to fill in"
DIGITS = 2
POSES = 20
"""Number of a trajectory's poses that are shown, evenly in time."""


def id_of(example: Example) -> str:
    """Return an example's id as a digest, for annotations' ids show which are right."""
    return sha256(f"{example.annotation.id} {example.node}".encode()).hexdigest()[:16]


def prediction_line(example: Example) -> PredictionLine:
    """Return the line of the form for an example, without its label."""
    groundings: dict[str, tuple[dict[str, object], ...]] = {
        role: tuple(map(_shown, getattr(example, role))) for role in ROLES if getattr(example, role)
    }
    return PredictionLine(
        example=id_of(example),
        command=example.annotation.command.id,
        text=example.annotation.command.text,
        type=example.sdc.type,
        words=" ".join(word.text for word in all_words(example.sdc)),
        groundings=groundings,
    )


def write_form(path: Path, examples: Iterable[Example]) -> int:
    """Write the form to fill in, a line for each example without a probability; return how many.

    They come in the order of their ids, which shows nothing either.
    """
    return write_lines(path, map(prediction_line, sorted(examples, key=id_of)))


def read_predictions(path: Path, examples: Sequence[Example]) -> FloatArray:
    """Read the probabilities of examples from a file, in their order; shape (n,).

    Each example has one line, which is filled in, and there are no others.
    """
    rows = {id_of(e): i for i, e in enumerate(examples)}
    result = np.full(len(examples), np.nan)
    first: dict[str, int] = {}
    for number, line in json_lines(path, PredictionLine, fix=FIX):
        key, where = line.example, f"{path}:{number}"
        if key not in rows:
            raise FormatError(
                f"there is no example {key!r} among those that are tested", where=where, fix=FIX
            )
        if first.setdefault(key, number) != number:
            raise FormatError(
                f"example {key!r} has a prediction in line {first[key]} already",
                where=where,
                fix="give one prediction an example",
            )
        if line.probability is None:
            raise FormatError(
                f"the prediction of example {key!r} isn't filled in",
                where=where,
                fix="give a probability",
            )
        result[rows[key]] = line.probability
    gone = np.flatnonzero(np.isnan(result))
    if len(gone):
        one = examples[gone[0]]
        raise FormatError(
            f"{len(gone)} of {len(examples)} examples have no prediction, such as {id_of(one)!r}",
            where=str(path),
            fix=FIX,
        )
    return result


@dataclass(frozen=True, slots=True)
class ComparedType:
    """Comparisons of accuracy on the examples of one row of the table."""

    type: RowType
    comparisons: Sequence[Comparison]


def compare_predictions(
    said: Mapping[str, Predictions], *, threshold: float, draws: int, seed: int
) -> list[ComparedType]:
    """Compare each two models' accuracy on the same examples, with whole scenarios as clusters."""
    one = next(iter(said.values()))
    right = {name: predicted_true(p, threshold) == p.label for name, p in said.items()}
    result = []
    for kind in ROW_TYPES:
        rows = np.flatnonzero((one.type == kind) | (kind == "overall"))
        if not len(rows):
            continue
        shares = {
            name: {str(i): float(is_right[i]) for i in rows} for name, is_right in right.items()
        }
        scenarios = {str(i): str(one.scenario[i]) for i in rows}
        compared = compare_commands(shares, scenarios, seed=seed, draws=draws)
        result.append(ComparedType(kind, compared))
    return result


def _shown(grounding: Grounding) -> dict[str, object]:
    if isinstance(grounding, Way):
        track = grounding.trajectory
        rows = np.unique(np.linspace(0, len(track) - 1, POSES).astype(int))
        poses = np.column_stack((track.xyz[rows], track.yaw[rows]))
        return {"poses": np.round(poses, DIGITS).tolist()}
    prism = grounding.prism
    where: dict[str, object] = {
        "middle": np.round(centre(prism), DIGITS).tolist(),
        "footprint": np.round(prism.xy, DIGITS).tolist(),
        "bottom": round(prism.z_min, DIGITS),
        "top": round(prism.z_max, DIGITS),
    }
    if isinstance(grounding, PhysicalObject):
        return {"id": grounding.id, "labels": list(grounding.labels), **where}
    return {"name": grounding.name, **where}
