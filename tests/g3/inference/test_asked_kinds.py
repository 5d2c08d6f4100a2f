"""Kinds of actions that words ask for are done."""

import pytest

from g3.actions.action_kinds import KINDS
from tests.g3.inference.following_commands import did, world


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("Drive away from the truck", "drive away"),
        ("Move away from the truck", "drive away"),
        ("Back away from the truck", "back up"),
        ("Turn away from the truck", "turn away"),
        ("Go past the truck", "drive past"),
        ("Go forward past the truck", "drive past"),
        ("Pass the truck", "drive past"),
        ("Face the truck", "face"),
        ("Turn towards the truck", "face"),
        ("Turn to face the truck", "face"),
        ("Line up with the truck", "line up"),
        ("Align the forks with the truck", "line up"),
        ("Park by the truck", "park"),
        ("Raise your forks", "raise forks"),
        ("Lower the forks", "lower forks"),
        ("Wait", "wait"),
        ("Wait at the truck", "drive to"),
        ("Turn to your left", "turn"),
        ("Lift the crate", "pick up"),
    ],
)
def test_the_kind_that_words_ask_for_is_done(text, kind, mirrored, grounder):
    side = -1 if mirrored else 1
    yard = world(truck_1=("truck", (12, 7 * side)), crate_1=("crate", (9, -5 * side)))
    assert [name for name, _ in did(grounder.follow(text, yard, least=0.0))] == [kind]


def test_kinds_that_nobody_asks_for_are_not_tried():
    on_request = {name for name, kind in KINDS.items() if kind.on_request}
    assert {"face", "drive away", "raise forks"} <= on_request
    assert not {"wait", "drive to", "drive past", "pick up", "put down"} & on_request
