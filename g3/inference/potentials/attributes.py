"""Attributes of things: their colours, their sizes and their loads.

"The red crate", "the tall box" and "the empty trailer" tell things apart that are called the same.
So each is compared with the scene's other things alike. Where a map says nothing of them, or all
are alike in this, nothing is measured.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import log

import numpy as np
import numpy.typing as npt

from g3.features.sets.order import fits
from g3.geometry.footprints import extent
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray, PhysicalObject
from g3.inference.potentials.cases import FactorCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.grounding_problem import things_of
from g3.language.discourse.groups import noun_leaf
from g3.language.discourse.negation import negated
from g3.language.lexicon.attribute_words import Dimension, colours_named, sizes_named
from g3.language.lexicon.field_words import bare_words
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC

CLEARLY = 1.1
"""People see that one thing is larger than another if it's so many times as large..."""
CLEARLY_M = 0.05
"""...and by so much; of volumes the side of a cube counts."""
_Members = npt.NDArray[np.intp]


@potential("colour", kind="factor", types=("OBJECT",), weight=log(0.001))
def colour(case: FactorCase) -> Measured:
    """A thing has the colour that words name, if its colour is known: "the red crate"."""
    off = _other_colours(case)
    return off is not None and _of_members(case, lambda members: bool(off[members].any()))


@potential("size", kind="factor", types=("OBJECT",), weight=log(0.01))
def size(case: FactorCase) -> Measured:
    """Nothing alike is clearly taller than "the tall box", nor smaller than "the small one"."""
    said = sizes_named(_adjectives(case.sdc))
    if not said:
        return False
    things = _things(case)
    extents = _extents(case, things)
    fit = fits(case.batch)[0, : len(things)]
    alike = _alike(case) & (fit >= fit[:, None])
    off = _other_colours(case)
    if off is not None:  # "the tall red box" is tall among red ones
        alike &= ~off
    more = [_more(extents, senses) & alike for senses in said]
    return _of_members(case, lambda members: any(_is_beaten(members, each) for each in more))


@potential("contents", kind="factor", types=("OBJECT",), weight=log(0.05))
def contents(case: FactorCase) -> Measured:
    """Nothing stands on what is empty, and something on what is loaded: "the empty trailer"."""
    said = (
        WORDS["empty"].intersection(_adjectives(case.sdc)),
        WORDS["laden"].intersection(_adjectives(case.sdc)),
    )
    if not any(said):
        return False
    problem = case.problem
    laden = set(problem.carriers.values())
    wrong = laden if said[0] else problem.surfaces - laden
    off = np.array([o.id in wrong for o in _things(case)])
    return _of_members(case, lambda members: bool(off[members].any()))


@potential(
    "carries", kind="factor", types=("OBJECT",), roles=("figure", "landmark"), weight=log(0.05)
)
def carries(case: FactorCase) -> Measured:
    """A truck "with the tires" has them on it."""
    sdc, problem = case.sdc, case.problem
    if not (
        WORDS["having"].intersection(bare_words(sdc.relation)) and problem.carriers
    ) or _has_nothing(sdc):
        return False
    groups, decks = problem.scene.groups, problem.surfaces
    under = problem.carriers

    def is_wrong(figure: int, landmark: int) -> bool:
        if max(figure, landmark) >= len(groups) or landmark < 0 or figure == landmark:
            return False
        own = {thing.id for thing in things_of(groups[figure])}
        there = {under.get(thing.id, "") for thing in things_of(groups[landmark])}
        return bool(own) and own <= decks and not there & own

    pairs = zip(case.batch.figure.tolist(), case.batch.landmark.tolist(), strict=True)
    return np.array([is_wrong(*pair) for pair in pairs])


def _adjectives(sdc: SDC) -> list[str]:
    """Return the adjectives of a clause itself: "the tall box", "that is red", "with nothing".

    What is said of a part of a thing isn't said of the thing: "the long side".
    """
    if sdc.words:
        said = bare_words(sdc.words)
        return [] if WORDS["parts"].intersection(said) else said
    if not sdc.landmark1:
        return bare_words(sdc.relation)
    return sorted(WORDS["empty"]) if _has_nothing(sdc) else []


def _has_nothing(sdc: SDC) -> bool:
    said = set(bare_words(sdc.relation))
    if not (sdc.landmark1 and said & WORDS["having"]):
        return False
    named = set(bare_words(noun_leaf(sdc.landmark1[0]).words))
    return bool((named | said) & WORDS["nothing"]) or (
        negated(sdc) and bool(named & WORDS["quantifiers"])
    )


def _things(case: FactorCase) -> tuple[PhysicalObject, ...]:
    return case.problem.state.context.objects


def _alike(case: FactorCase) -> BoolArray:
    """Find the context's objects that share a label with others, shape (n, n)."""
    n = len(_things(case))
    labels = case.batch.bodies.labels[:n]
    alike: BoolArray = (labels @ labels.T) & ~np.eye(n, dtype=bool)
    return alike


def _other_colours(case: FactorCase) -> BoolArray | None:
    """Find the context's objects that aren't in a colour that words name, shape (n,).

    Who says a colour means to tell things apart. So what nobody has said the colour of hasn't it if
    another one alike has. None where words name no colour, or none is known.
    """
    said = colours_named(_adjectives(case.sdc))
    own = [thing.colours for thing in _things(case)]
    if not (said and any(own)):
        return None
    known = np.array([bool(colours) for colours in own])
    right = np.array([bool(said.intersection(colours)) for colours in own])
    other: BoolArray = ~right & (known | (_alike(case) & right).any(axis=1))
    return other


def _extents(case: FactorCase, things: Iterable[PhysicalObject]) -> dict[Dimension, FloatArray]:
    """Sizes of objects in metres, shape (n,) each; NaN for the robot's and for what is assumed."""
    context = case.problem.state.context
    unknown = {name for name, aspect in context.assumed if aspect == "size"} | {context.agent_id}
    table = np.array(
        [
            [np.nan] * 3 if o.id in unknown else extent(o.prism, float(o.trajectory.yaw[0]))
            for o in things
        ]
    )
    sides, height = np.sort(table[:, :2], axis=1), table[:, 2]
    side = np.cbrt(table.prod(axis=1))
    return {"height": height, "length": sides[:, 1], "width": sides[:, 0], "volume": side}


def _more(
    extents: dict[Dimension, FloatArray], senses: Iterable[tuple[Dimension, int]]
) -> BoolArray:
    """Check that things in columns have clearly more of what an adjective says than those in rows.

    Of several senses the first counts in which two things differ: what is short is low or not long.
    """
    n = len(extents["height"])
    more, same = np.zeros((n, n), dtype=bool), np.ones((n, n), dtype=bool)
    for dimension, pole in senses:
        own = extents[dimension]
        low, high = np.minimum(own[:, None], own), np.maximum(own[:, None], own)
        differ = high > np.maximum(CLEARLY * low, low + CLEARLY_M)
        more |= same & differ & (pole * own > pole * own[:, None])
        same &= ~differ
    return more


def _is_beaten(members: _Members, more: BoolArray) -> bool:
    least = np.flatnonzero(more.any(axis=1) & ~more.any(axis=0))
    others = more[members]
    others[:, members] = False
    return bool(others.any() or np.isin(members, least).any())


def _of_members(case: FactorCase, measure: Callable[[_Members], float]) -> FloatArray:
    """Measure the members of each row's figure; nothing of places."""
    place = {thing.id: i for i, thing in enumerate(_things(case))}
    groups = case.problem.scene.groups
    found = np.zeros(len(groups) + 1)
    for i, group in enumerate(groups):
        members = [place[thing.id] for thing in things_of(group)]
        if members:
            found[i] = measure(np.array(members))
    return found[np.minimum(case.batch.figure, len(groups))]
