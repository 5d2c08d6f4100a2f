"""Other objects and places of a scene than the ones that a clause means."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from g3.actions.grounding_candidates import are_free, beneath, ground, spots_about
from g3.actions.logged_actions import recorded
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.geometry.footprints import centre
from g3.groundings import FloatArray, Grounding, PhysicalObject, Place, Prism
from g3.language.lexicon.field_words import field_words, normalise
from g3.negatives.wrongness import Clause, distance
from g3.sdc.clauses import SDC, all_words, breadth_first

Labels = tuple[str, ...]
Usage = Mapping[tuple[str, ...], frozenset[Labels]]
"""For the words of an OBJECT, the labels of everything that they are ever right for."""

ANOTHER_PLACE_M = 3.0
SAME_LABELS = 0.5
"""Share of candidates for OBJECTs with a relation that are drawn from those alike."""
SAME_HEIGHT = 0.75
"""Share of candidates for places drawn from those about as high as the right one."""
_DETERMINERS = {"the", "a", "an", "this", "that", "these", "those"}


def usage(positives: Iterable[Annotation]) -> Usage:
    """What the OBJECTs of positive annotations are used for."""
    seen: dict[tuple[str, ...], set[Labels]] = defaultdict(set)
    for annotation in positives:
        for sdc, groundings in zip(
            breadth_first(annotation.sdcs), annotation.groundings, strict=True
        ):
            if sdc.type == "OBJECT":
                seen[_wording(sdc)].update(
                    g.labels for g in groundings if isinstance(g, PhysicalObject)
                )
    return {words: frozenset(labels) for words, labels in seen.items()}


def other_things(clause: Clause, words: Usage, rng: np.random.Generator) -> tuple[Grounding, ...]:
    """As many wrong groundings as an OBJECT or PLACE clause has right ones, if there are any.

    An OBJECT that is described by what it is ("the box pallet", "the pallet of boxes")
    gets one with other labels, for which its words are never used in the corpus and
    which they don't name: "the pallet" names every pallet. One that is described by how
    it lies to others gets any other object, a place another one at least
    `ANOTHER_PLACE_M` away.
    """
    right = clause.groundings
    places = [g for g in right if isinstance(g, Place)]
    objects = [g for g in right if isinstance(g, PhysicalObject)]
    if objects and not places:
        return _draw(_other_objects(clause, objects, words, rng), len(objects), rng)
    if places and not objects:
        found = _other_places(clause, places)
        level = [p for p in found if abs(p.prism.z_min - places[0].prism.z_min) < 0.3]
        uneven = [p for p in found if abs(p.prism.z_min - places[0].prism.z_min) >= 0.3]
        first, second = (level, uneven) if rng.random() < SAME_HEIGHT else (uneven, level)
        return _draw(first or second, len(places), rng)
    return ()


def _draw(
    found: Sequence[Grounding], count: int, rng: np.random.Generator
) -> tuple[Grounding, ...]:
    chosen = rng.permutation(len(found))[:count]
    return tuple(found[i] for i in chosen)


def _wording(sdc: SDC) -> tuple[str, ...]:
    return tuple(sorted(set(field_words(all_words(sdc))) - _DETERMINERS))


def _is_by_kind(clause: Clause) -> bool:
    """Whether an OBJECT is a leaf, or related only to what it is made of."""
    own = {g.id for g in clause.groundings if isinstance(g, PhysicalObject)}
    landmarks = [g.id if isinstance(g, PhysicalObject) else None for g in clause.landmarks]
    return clause.sdc.is_leaf or (bool(landmarks) and own.issuperset(landmarks))


def _other_objects(
    clause: Clause, right: Sequence[PhysicalObject], words: Usage, rng: np.random.Generator
) -> list[PhysicalObject]:
    ids = {o.id for o in right}
    labels = {o.labels for o in right}
    others = [o for o in recorded(clause.context).objects if o.id not in ids]
    if not _is_by_kind(clause):
        alike = [o for o in others if o.labels in labels]
        return alike if alike and rng.random() < SAME_LABELS else others
    wording = _wording(clause.sdc)
    used = words.get(wording, frozenset())

    def fits(thing: PhysicalObject) -> bool:
        named = {normalise(label) for label in thing.labels}.issuperset(wording)
        return thing.labels in labels | used or named

    return [o for o in others if not fits(o)]


def _other_places(clause: Clause, right: Sequence[Place]) -> list[Place]:
    """The right place moved to where another might be; so its shape tells nothing."""
    state, model = start_state(clause.context), right[0]
    under = beneath(model, state, None)
    height = model.prism.z_min - _top(under, state)
    named = {g.id for g in clause.things if isinstance(g, PhysicalObject)}
    spots = [(place, beneath(place, state, None)) for place in state.context.places]
    for thing in recorded(state.context).objects:
        about = ((spot, beneath(spot, state, None)) for spot in spots_about((thing,), state))
        spots += [(spot, on) for spot, on in about if on is not None or thing.id not in named]
    found = [
        Place(_shifted(model.prism, centre(spot.prism), _top(on, state) + height))
        for spot, on in spots
        if on is None or under is None or on.id != under.id
    ]
    far = [p for p in found if all(distance(p, r) > ANOTHER_PLACE_M for r in right)]
    return [p for p, free in zip(far, are_free(far, state, None), strict=True) if free]


def _top(thing: PhysicalObject | None, state: State) -> float:
    return ground(state) if thing is None else thing.prism.z_max


def _shifted(prism: Prism, middle: FloatArray, bottom: float) -> Prism:
    xy = prism.xy + middle - centre(prism)
    return Prism(xy, bottom, bottom + (prism.z_max - prism.z_min))
