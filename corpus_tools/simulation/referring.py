"""References to things: nouns, and distinctions of a thing from others of its kind.

A worker takes a noun that fits, and sees which other things it fits as well. Then they add
something that is true of the thing meant alone: its colour or height, what it stands on or next to,
or its order in the row as the robot sees it. A vague worker leaves that out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.simulation.seen_scenes import Scene, Seen, distance
from corpus_tools.simulation.wording import Wording, clause
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

CLEARLY_M = 1.0
"""Least distance by which a thing lies further to a side, or nearer, in metres."""
CLEARLY_TALLER = 1.2
"""Least ratio of a tall thing's height to that of one that is not tall."""
BY_M = 4.0
"""Largest distance from a landmark of a thing "next to" it, in metres."""


@short_repr
@dataclass(frozen=True, slots=True)
class Noun:
    """A way to name a kind of thing."""

    labels: frozenset[str]
    """Labels that a thing must have for the noun to fit."""
    head: str
    """The noun, without an article."""
    of: str = ""
    """Load of the thing, as in "pallet of tires"; empty if the noun doesn't name it."""


def _nouns(labels: Sequence[str], *names: str) -> tuple[Noun, ...]:
    found = []
    for name in names:
        head, _, of = name.partition(" of ")
        found.append(Noun(frozenset(labels), head, of))
    return tuple(found)


_PALLET = _nouns(("pallet",), "pallet", "skid")
NOUNS = {
    "tire-pallet": (
        *_nouns(("tire", "pallet"), "tire pallet", "pallet of tires", "skid of tires", "tires"),
        *_PALLET,
    ),
    "box-pallet": (
        *_nouns(("box", "pallet"), "box pallet", "pallet of boxes", "boxes"),
        *_PALLET,
    ),
    "crate": _nouns(("crate",), "crate"),
    "truck": _nouns(("truck",), "truck", "lorry"),
    "trailer": _nouns(("trailer",), "trailer", "flatbed"),
    "shelf": _nouns(("shelf",), "shelf"),
    "barrel": _nouns(("barrel",), "barrel"),
    "person": _nouns(("person",), "person", "man", "worker"),
    "cone": _nouns(("cone",), "cone"),
}
"""Nouns for each kind; the first names are no commoner than the others."""

_ORDINALS = ("first", "second", "third", "fourth", "fifth")


def refer(
    wording: Wording, scene: Scene, thing: Seen, rng: np.random.Generator, *, vague: bool
) -> SDC:
    """Type a phrase for a thing, and return its OBJECT clause.

    A `vague` worker doesn't care if the phrase fits other things too.
    """
    nouns = NOUNS[thing.kind]
    noun = nouns[int(rng.integers(len(nouns)))]
    rivals = [t for t in scene.things.values() if t.id != thing.id and noun.labels <= t.labels]
    known = _distinctions(scene, thing, rivals) if rivals and not vague else []
    if not known:
        return _phrase(wording, noun, thing)
    return known[int(rng.integers(len(known)))].say(wording, noun, thing, rng)


def name_place(wording: Wording, place: Seen, rng: np.random.Generator) -> SDC:
    """Type the name of a place on the map, and return its OBJECT clause."""
    name = place.name
    lettered = name.split()[-1].isupper()  # "storage A"
    long = f"the {name}" if " " in name else f"the {name} area"
    return wording.leaf(name if lettered or rng.random() < 0.5 else long, place.id)


@dataclass(frozen=True, slots=True)
class _Distinction:
    """Property of one thing alone: an adjective, or a relation with perhaps a landmark."""

    adjective: str = ""
    relation: str = ""
    landmark: Seen | None = None

    def say(self, wording: Wording, noun: Noun, thing: Seen, rng: np.random.Generator) -> SDC:
        phrase = _phrase(wording, noun, thing, self.adjective)
        if not self.relation:
            return phrase
        relation = wording.say(self.relation)
        if self.landmark is None:
            return clause("OBJECT", relation, figure=phrase)
        nouns = NOUNS[self.landmark.kind]
        landmark = _phrase(wording, nouns[int(rng.integers(len(nouns)))], self.landmark)
        return clause("OBJECT", relation, landmark, figure=phrase)


def _phrase(wording: Wording, noun: Noun, thing: Seen, adjective: str = "") -> SDC:
    words = " ".join(filter(None, ("the", adjective, noun.head)))
    head = wording.leaf(words, thing.id)
    if not noun.of:
        return head
    relation = wording.say("of")
    return clause("OBJECT", relation, wording.leaf(noun.of, thing.id), figure=head)


def _distinctions(scene: Scene, thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    return [
        *_likenesses(thing, rivals),
        *_sides(thing, rivals),
        *_ranges(thing, rivals),
        *_decks(scene, thing, rivals),
        *_neighbours(scene, thing, rivals),
    ]


def _likenesses(thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by a look that it alone has: its colour, or its height."""
    found: list[str] = [
        colour
        for colour in thing.colours[:1]
        if not any(colour in rival.colours for rival in rivals)
    ]
    heights = [rival.height for rival in rivals]
    if thing.height > CLEARLY_TALLER * max(heights):
        found += ["tall", "tallest"]
    if CLEARLY_TALLER * thing.height < min(heights):
        found += ["short", "shortest"]
    return [_Distinction(adjective) for adjective in found]


def _sides(thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions from left to right as the robot sees it, if all are in front of it."""
    row = sorted((thing, *rivals), key=lambda t: -t.at[1])
    across = [t.at[1] for t in row]
    if min(t.at[0] for t in row) <= 0 or min(-np.diff(across)) < CLEARLY_M:
        return []
    place = row.index(thing)
    found = []
    for side, rank in (("left", place), ("right", len(row) - 1 - place)):
        if rank == 0:
            found += [
                _Distinction(adjective=f"{side}most"),
                _Distinction(relation=f"on the {side}"),
                _Distinction(adjective=side),
            ]
        if len(row) > 2 and rank < len(_ORDINALS):
            found.append(_Distinction(_ORDINALS[rank], f"from the {side}"))
    return found


def _ranges(thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by distance from the robot."""
    own = np.hypot(*thing.at)
    others = [np.hypot(*rival.at) for rival in rivals]
    if own + CLEARLY_M < min(others):
        return [_Distinction(a) for a in ("nearest", "closest")]
    if own > max(others) + CLEARLY_M:
        return [_Distinction("farthest")]
    return []


def _decks(scene: Scene, thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by its support."""
    if not thing.deck or any(rival.deck for rival in rivals):
        return []
    return [_Distinction(relation="on", landmark=scene.things[thing.deck])]


def _neighbours(scene: Scene, thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by a thing of another kind, unique in kind, that it alone is next to."""
    kinds = [t.kind for t in scene.things.values()]
    found = []
    for other in scene.things.values():
        if other.deck or thing.deck or other.kind == thing.kind or kinds.count(other.kind) > 1:
            continue
        if other not in rivals and distance(thing, other) < BY_M:
            apart = min(distance(rival, other) for rival in rivals)
            if apart > distance(thing, other) + 2 * CLEARLY_M:
                found += [_Distinction(relation=r, landmark=other) for r in ("next to", "near")]
    return found
