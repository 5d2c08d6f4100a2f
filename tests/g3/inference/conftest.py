"""A model trained on a few bundled scenarios, and a world that it hasn't seen."""

import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from g3.inference.grounder import Grounder
from g3.learning.grounding_model import GroundingModel
from tests.g3.inference.following_commands import TIRES


@pytest.fixture(scope="session")
def warehouse():
    return open_corpus("warehouse")


@pytest.fixture(scope="session")
def model(trained):
    return GroundingModel.load(trained("two-scenarios"))


@pytest.fixture(scope="session")
def grounder(model):
    return Grounder.load(model)


@pytest.fixture(scope="session")
def dock(warehouse):
    return next(
        a.context for a in warehouse.annotations if a.command.scenario == "dock_pick_up_tires"
    )


@pytest.fixture(scope="session")
def widely_trained(trained):
    """A grounder that has learned from a quarter of all commands, of all scenarios."""
    return Grounder.load(trained("all-scenarios"))


@pytest.fixture
def loaded_truck():
    """A truck with one pallet of tires; another one is on the ground."""
    return {
        "truck_1": ("truck", (10, 0)),
        "tires_1": (TIRES, (8, 0), 0, "truck-1"),
        "tires_3": (TIRES, (6, -5)),
    }
