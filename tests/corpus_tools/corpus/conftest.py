from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation, Command, Judgment
from g3.groundings import Context, PhysicalObject, Place, Prism, Trajectory
from g3.sdc.clauses import SDC, Span


def square(x: float, y: float) -> Prism:
    return Prism(np.array([[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]]), 0.0, 0.5)


@pytest.fixture
def small_corpus() -> Corpus:
    """One command, "Pick it up", grounded in a robot and two pallets."""
    still = Trajectory(np.zeros(1), np.array([[0.5, 0.5, 0.0]]), np.zeros(1))
    moving = Trajectory(np.arange(3.0), np.arange(9.0).reshape(3, 3), np.zeros(3))
    robot = PhysicalObject("robot", ("forklift",), square(0, 0), moving)
    pallets = [PhysicalObject(name, ("pallet",), square(0, 0), still) for name in ("p1", "p2")]
    context = Context("world", (robot, *pallets), (Place(square(5, 5), "dock"),), "robot")
    command = Command("s-01", "Pick it up", "s", "v1", "subject 1")
    pick = SDC(
        "EVENT",
        relation=(Span(0, "Pick"), Span(8, "up")),
        figure=(SDC("OBJECT"),),
        landmark1=(SDC("OBJECT", words=(Span(5, "it"),)),),
    )
    annotation = Annotation(
        "s-01/positive",
        command,
        context,
        (pick,),
        ((robot,), (), tuple(pallets)),
        (True, None, True),
        "positive",
    )
    return Corpus.build(
        "small",
        contexts=[context],
        commands=[command, Command("s-02", "", "s", "v1")],
        annotations=[annotation],
        judgments=[
            Judgment("j1", "Pick it up", "v1", "v1", "SA", "rater 1", "study"),
            Judgment("j2", "Pick it up", "v1", "v2", "D", "rater 2", "study"),
        ],
        source="made up",
        licence="none",
    )


@pytest.fixture
def corpus_path(small_corpus: Corpus, tmp_path: Path) -> Path:
    path = tmp_path / "corpus"
    small_corpus.save(path)
    return path
