"""Models to follow commands that are trained once a run, for all workers.

They are trained in seconds, for tests where what they have learned counts little.
"""

from __future__ import annotations

import fcntl
from pathlib import Path

from corpus_tools.importers.authored.bundled import open_corpus
from g3.annotation import Annotation
from g3.inference.training import TOLERANCE, search_sets, training_data
from g3.learning.grounding_model import GroundingModel


def _every(step: int, *scenarios: str) -> list[Annotation]:
    """Annotations of one in so many bundled commands, of some scenarios or of all."""
    chosen = [
        a
        for a in open_corpus("warehouse").annotations
        if not scenarios or a.command.scenario in scenarios
    ]
    commands = set(list(dict.fromkeys(a.command.id for a in chosen))[::step])
    return [a for a in chosen if a.command.id in commands]


LESSONS = {
    "one-scenario": lambda: _every(1, "hall_pick_up_boxes"),
    "two-scenarios": lambda: _every(2, "court_put_crate_on_trailer", "hall_pick_up_boxes"),
    "all-scenarios": lambda: _every(4),
}


def trained_in(folder: Path, name: str) -> Path:
    """Return the file of a model of `LESSONS`; who asks first trains it, others wait."""
    path = folder / f"{name}.npz"
    with (folder / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.with_suffix(".json").exists():  # which is written last
            data = training_data(LESSONS[name](), search_sets())
            GroundingModel(tolerance=TOLERANCE).fit(data).save(path)
    return path
