"""Other objects and places of a scene than the ones that a clause means."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from g3.actions.action_candidates import is_free
from g3.actions.logged_actions import centre, covers, recorded
from g3.annotation import Annotation
from g3.geometry.plane import area, convex_hull
from g3.groundings import Context, FloatArray, Grounding, PhysicalObject, Place, Prism
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
BESIDE_M = 2.0
_DETERMINERS = {"the", "a", "an", "this", "that", "these", "those"}
SURFACE_M2 = 4.0


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
    context, model = clause.context, right[0]
    things = recorded(context).objects
    beneath = _beneath(context, model)
    height = model.prism.z_min - _top(context, beneath)
    named = {g.id for g in clause.things if isinstance(g, PhysicalObject)}
    spots = [(centre(p.prism), _beneath(context, p)) for p in context.places]
    for thing in things:
        middle = centre(thing.prism)
        if area(convex_hull(thing.prism.xy)[None])[0] >= SURFACE_M2:
            spots.append((middle, thing))
        elif thing.id not in named and _beneath(context, thing) is None:
            yaw = thing.trajectory.yaw[0]
            sides = yaw + np.pi / 2 * np.arange(4)
            around = middle + BESIDE_M * np.column_stack((np.cos(sides), np.sin(sides)))
            spots += [(spot, None) for spot in around]
    moved = [
        Place(_shifted(model.prism, spot, _top(context, under) + height))
        for spot, under in spots
        if under is None or beneath is None or under.id != beneath.id
    ]
    return [
        place
        for place in moved
        if all(distance(place, r) > ANOTHER_PLACE_M for r in right)
        and is_free(context, place.prism, None)
    ]


def _beneath(context: Context, thing: Place | PhysicalObject) -> PhysicalObject | None:
    """What something stands on, None for the ground."""
    middle = centre(thing.prism)
    own = thing.id if isinstance(thing, PhysicalObject) else None
    return next(
        (
            o
            for o in recorded(context).objects
            if o.id != own and o.prism.z_max < thing.prism.z_min + 0.3 and covers(o.prism, middle)
        ),
        None,
    )


def _top(context: Context, thing: PhysicalObject | None) -> float:
    return float(context.agent.trajectory.xyz[0, 2]) if thing is None else thing.prism.z_max


def _shifted(prism: Prism, middle: FloatArray, bottom: float) -> Prism:
    xy = prism.xy + middle - centre(prism)
    return Prism(xy, bottom, bottom + (prism.z_max - prism.z_min))
