"""Ways that words name without a landmark."""

import numpy as np
import pytest

from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import BACK_UP, GO_STRAIGHT, PUT_DOWN, TURN, WAIT
from tests.g3.inference.ruled import WEIGHT, of_actions

ACTIONS = {
    "wait": Action(WAIT),
    "ahead": Action(GO_STRAIGHT, amount=4.0),
    "back": Action(BACK_UP, amount=-4.0),
    "left": Action(TURN, amount=np.pi / 2),
    "right": Action(TURN, amount=-np.pi / 2),
    "around": Action(TURN, amount=np.pi),
    "put": Action(PUT_DOWN, object_id="boxes-1"),
}


@pytest.mark.parametrize(
    ("notation", "free"),
    [
        ("EVENT(r = Go forward)", {"ahead"}),
        ("EVENT(r = Go, l = PATH(r = straight ahead))", {"ahead"}),
        ("EVENT(r = Back up)", {"back"}),
        ("EVENT(r = swing, l = PLACE(r = to the right))", {"right"}),
        ("EVENT(r = turn left)", {"left"}),
        ("EVENT(r = Turn around)", {"around"}),
        ("EVENT(r = Go back left)", {"back", "left"}),
        ("EVENT(r = Move forward, l = OBJ(f = a bit))", {"ahead"}),
        # No way is named, or it is that of a thing.
        ("EVENT(r = Drive)", ACTIONS.keys()),
        ("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the left truck)))", ACTIONS.keys()),
    ],
)
def test_another_way_than_words_name_costs(notation, free):
    cost = dict(zip(ACTIONS, of_actions("way", notation, [*ACTIONS.values()]), strict=True))
    # What handles a load leads to more than a way.
    assert {name for name, c in cost.items() if c == 0.0} == {*free, "put"}
    assert set(cost.values()) <= {0.0, WEIGHT["way"]}
