"""A model that is trained in seconds, where what it is told by doesn't count."""

from __future__ import annotations

from pathlib import Path

from corpus_tools.importers.authored.bundled import open_corpus
from g3.inference.training import TOLERANCE, search_sets, training_data
from g3.learning.grounding_model import GroundingModel


def save_small_model(path: Path) -> Path:
    """Train a model to follow commands on one bundled scenario, and save it."""
    annotations = open_corpus("warehouse").annotations
    known = [a for a in annotations if a.command.scenario == "hall_pick_up_boxes"]
    GroundingModel(tolerance=TOLERANCE).fit(training_data(known, search_sets())).save(path)
    return path
