"""What the forks can lift, by what a scenario says, by size and by labels."""

from dataclasses import replace

import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from eval.judging.judge import picked_in_log
from g3.actions.robot_state import (
    can_be_lifted,
    is_load,
    loads_of_context,
    names_person,
    start_state,
)
from tests.worlds import thing


def test_what_forks_can_lift_is_neither_too_small_nor_too_large():
    sizes = {
        "tire pallet": ((1.2, 1.0), (0, 0.7)),
        "crate": ((1, 1), (0, 0.9)),
        "refrigerator pallet": ((1.2, 1.0), (0, 1.95)),
        "drum": ((0.6, 0.6), (0, 0.9)),
        "sign post": ((0.3, 0.9), (0, 2.4)),
        "cone": ((0.4, 0.4), (0, 0.7)),
        "berm": ((6, 2.5), (0, 1.4)),
        "shelf": ((3, 1), (0, 2.6)),
    }
    found = {
        labels
        for labels, (size, z) in sizes.items()
        if can_be_lifted(thing("x", labels, 0, 0, size, z))
    }
    assert found == {"tire pallet", "crate", "refrigerator pallet"}


@pytest.mark.parametrize("labels", ["person", "operator", "supervisor", "foreman", "man", "worker"])
def test_nobody_is_lifted_however_large(labels):
    assert not can_be_lifted(thing("x", labels, 0, 0, (1.0, 1.0)))


@pytest.mark.parametrize("labels", ["generator", "box", "machine", "boxes", "trailer", "pallet"])
def test_things_are_no_people(labels):
    assert not names_person((labels,))


def test_a_thing_may_be_said_to_be_liftable_or_not():
    drum, crate = thing("d", "drum", 0, 0, (0.6, 0.6)), thing("c", "crate", 0, 0, (1, 1))
    assert can_be_lifted(replace(drum, liftable=True))
    assert not can_be_lifted(replace(crate, liftable=False))


def test_whatever_was_picked_up_in_the_bundled_corpus_is_a_load():
    for context in open_corpus("warehouse").contexts.values():
        loads = {o.id for o in loads_of_context(context)}
        assert picked_in_log(context) <= loads
        assert context.agent_id not in loads
        state = start_state(context)
        assert loads == {o.id for o in context.objects if is_load(state, o.id)}
