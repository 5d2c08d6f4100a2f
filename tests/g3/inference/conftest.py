"""A model trained on a few bundled scenarios, and a world that it hasn't seen."""

import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from g3.inference.grounder import Grounder
from g3.inference.training import TOLERANCE, search_sets, training_data
from g3.learning.grounding_model import GroundingModel
from tests.g3.inference.following_commands import TIRES

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


@pytest.fixture(scope="session")
def widely_trained(warehouse):
    """A grounder that has learned from a quarter of all commands, of all scenarios."""
    commands = dict.fromkeys(a.command.id for a in warehouse.annotations)
    quarter = {command for i, command in enumerate(commands) if i % 4 == 0}
    known = [a for a in warehouse.annotations if a.command.id in quarter]
    data = training_data(known, search_sets())
    return Grounder.load(GroundingModel(tolerance=TOLERANCE).fit(data))


@pytest.fixture
def loaded_truck():
    """A truck with one pallet of tires; another one is on the ground."""
    return {
        "truck_1": ("truck", (10, 0)),
        "tires_1": (TIRES, (8, 0), 0, "truck-1"),
        "tires_3": (TIRES, (6, -5)),
    }
