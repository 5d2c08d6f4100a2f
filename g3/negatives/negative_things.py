"""Other objects and places of a scene than the ones that a clause means."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from g3.actions.grounding_candidates import are_free, beneath, ground, spots_about
from g3.actions.logged_actions import recorded
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.features.sets.order import is_ordinal
from g3.geometry.footprints import apart, centre
from g3.groundings import FloatArray, Grounding, Path, PhysicalObject, Place, Prism
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import field_words, normalise
from g3.negatives.wrongness import Clause
from g3.sdc.clauses import SDC, all_words, breadth_first

Labels = tuple[str, ...]
Usage = Mapping[tuple[str, ...], frozenset[Labels]]
"""For the words of an OBJECT, the labels of everything that they are ever right for."""

ANOTHER_PLACE_M = 3.0
SAME_LABELS = 0.5
"""Share of candidates for OBJECTs that are drawn from those alike, where there are some."""
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

    An OBJECT gets other objects, as :func:`wrong_objects` finds them, a PLACE another one at least
    `ANOTHER_PLACE_M` away.
    """
    right = clause.groundings
    places = [g for g in right if isinstance(g, Place)]
    objects = [g for g in right if isinstance(g, PhysicalObject)]
    if objects and not places:
        alike, unlike = wrong_objects(clause, words)
        some = alike if alike and rng.random() < SAME_LABELS else [*alike, *unlike]
        return _draw(some, len(objects), rng)
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


def tells_apart(clause: Clause) -> bool:
    """Whether an OBJECT's words name more than a kind of thing: how it lies, which one it is.

    "The pallet of boxes" names a kind, for its landmark is what it is made of.
    """
    own = {g.id for g in clause.groundings if isinstance(g, PhysicalObject)}
    landmarks = [g.id if isinstance(g, PhysicalObject) else None for g in clause.landmarks]
    if not clause.sdc.is_leaf and not (landmarks and own.issuperset(landmarks)):
        return True
    words = field_words(all_words(clause.sdc))
    return bool(concepts(words)) or any(is_ordinal(word) for word in words)


def wrong_objects(
    clause: Clause, words: Usage
) -> tuple[list[PhysicalObject], list[PhysicalObject]]:
    """Objects of the scene that an OBJECT clause surely doesn't mean.

    Returns
    -------
    tuple
        Those with the labels of its own, if its words distinguish these; and others. Where words
        only name a kind ("the box pallet"), these are things for which they are never used and
        which they don't name: "the pallet" names every pallet.
    """
    right = [g for g in clause.groundings if isinstance(g, PhysicalObject)]
    ids, labels = {o.id for o in right}, {o.labels for o in right}
    others = [o for o in recorded(clause.context).objects if o.id not in ids]
    unlike = [o for o in others if o.labels not in labels]
    if tells_apart(clause):
        return [o for o in others if o.labels in labels], unlike
    wording = _wording(clause.sdc)
    used = words.get(wording, frozenset())
    named = {o.id for o in unlike if {normalise(label) for label in o.labels}.issuperset(wording)}
    return [], [o for o in unlike if o.labels not in used and o.id not in named]


def far_places(spots: Iterable[Place], right: Sequence[Grounding], metres: float) -> list[Place]:
    """The spots that are surely not what a PLACE means: so far away from all that is right."""
    things = [g for g in right if not isinstance(g, Path)]
    return [s for s in spots if all(apart(s.prism, thing.prism) > metres for thing in things)]


def _other_places(clause: Clause, right: Sequence[Place]) -> list[Place]:
    """The right place moved to where another might be; so its shape tells nothing.

    Elsewhere than on what it is on, and not beside what the clause names.
    """
    state, model = start_state(clause.context), right[0]
    own = beneath(model, state, None)
    height = model.prism.z_min - _top(own, state)
    named = {g.id for g in clause.things if isinstance(g, PhysicalObject)}
    spots = [(place, beneath(place, state, None)) for place in state.context.places]
    for thing in recorded(state.context).objects:
        about = ((spot, beneath(spot, state, None)) for spot in spots_about((thing,), state))
        spots += [(spot, on) for spot, on in about if on is not None or thing.id not in named]
    found = [
        Place(_shifted(model.prism, centre(spot.prism), _top(on, state) + height))
        for spot, on in spots
        if on is None or on is not own
    ]
    far = far_places(found, right, ANOTHER_PLACE_M)
    return [p for p, free in zip(far, are_free(far, state, None), strict=True) if free]


def _top(thing: PhysicalObject | None, state: State) -> float:
    return ground(state) if thing is None else thing.prism.z_max


def _shifted(prism: Prism, middle: FloatArray, bottom: float) -> Prism:
    xy = prism.xy + middle - centre(prism)
    return Prism(xy, bottom, bottom + (prism.z_max - prism.z_min))
