from __future__ import annotations

import pytest

from annotation_app.tasks.agreement import f_score, figures, mean_of_pairs, spans, tree_f
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import parse_brackets

COMMAND = "Put the pallet on the truck"


def trees(notation: str) -> tuple[SDC, ...]:
    return parse_brackets(notation, command=COMMAND)


FLAT = trees("EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))")
ATTACHED = trees("EVENT(r = Put, l = OBJ(f = OBJ(f = the pallet), r = on, l = OBJ(f = the truck)))")


def test_f_scores_by_hand() -> None:
    # Flat: EVENT, OBJ the pallet, PLACE on the truck, OBJ the truck. Attached: EVENT, OBJ the
    # pallet on the truck, OBJ the pallet, OBJ the truck. Three of four are spans of both.
    assert f_score(spans(FLAT), spans(ATTACHED)) == pytest.approx(3 / 4)
    # As nodes only the EVENT is the same: "the pallet" and "the truck" hang elsewhere.
    assert tree_f(FLAT, ATTACHED) == pytest.approx(1 / 4)
    assert tree_f(FLAT, FLAT) == tree_f((), ()) == 1.0
    assert tree_f(FLAT, ()) == 0.0


def test_pairs() -> None:
    # The pairs of the first command: same, 1/4, 1/4; the second has one annotation.
    trees = mean_of_pairs({"tree F": tree_f})
    (found,) = figures([trees], [[trees.units([FLAT, FLAT, ATTACHED])], [trees.units([FLAT])]])
    assert (found.value, found.units) == (pytest.approx(0.5), 3)
    (nothing,) = trees.figures([])
    assert (nothing.value, nothing.units, nothing.reason) == (None, 0, "no overlap")
