"""A model trained on a few bundled scenarios, and a world that it hasn't seen."""

import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from g3.inference.grounder import Grounder
from g3.inference.training.search_training import TOLERANCE, search_sets, training_data
from g3.learning.grounding_model import GroundingModel

KNOWN = ("court_put_crate_on_trailer", "hall_pick_up_boxes")
"""The scenarios that the model learns from."""


@pytest.fixture(scope="session")
def warehouse():
    return open_corpus("warehouse")


@pytest.fixture(scope="session")
def model(warehouse):
    known = [a for a in warehouse.annotations if a.command.scenario in KNOWN]
    few = {c: i for i, c in enumerate(dict.fromkeys(a.command.id for a in known)) if i % 2 == 0}
    data = training_data([a for a in known if a.command.id in few], search_sets())
    return GroundingModel(tolerance=TOLERANCE).fit(data)


@pytest.fixture(scope="session")
def grounder(model):
    return Grounder.load(model)


@pytest.fixture(scope="session")
def dock(warehouse):
    return next(
        a.context for a in warehouse.annotations if a.command.scenario == "dock_pick_up_tires"
    )
