"""Checks of an end position against the words of a PLACE or a PATH."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from eval.judging.allowed_things import allowed
from eval.judging.grounded_command import GroundedCommand, Things
from eval.judging.layout import BESIDE_M, NEAR_M, is_between, looking_at, nearest, seen
from eval.judging.modifiers import unplaced
from g3.actions.grounding_candidates import beneath
from g3.actions.robot_state import State
from g3.geometry.footprints import centre, covers
from g3.groundings import FloatArray, Place, Prism
from g3.inference.problem.phrases import is_area, is_there, names_robot, unstressed
from g3.language.lexicon.concepts import Concept, concepts
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.word_sets import BESIDE, ENDS, FLOOR, SIDES
from g3.short_repr import short_repr

SLACK_M = 0.5
"""Largest distance outside an annotated region that still counts as in it, in metres."""
ROBOT_M = 2.0
"""Largest distance of the robot from a region that it is sent to, in metres."""
DECK_M = 0.4
"""A height between the ground and the decks of vehicles, in metres."""
SHORT_M = 4.0
"""Additional tolerance for a load that is still on the forks, in metres."""
TURNS_M = 0.7
"""Smallest distance to a side that counts as going to that side, in metres."""


@short_repr
@dataclass(frozen=True, slots=True)
class Ending:
    """An object's position and shape before and after an execution."""

    thing: str
    """Id of the object."""
    first: Prism
    last: Prism
    """Shapes at the start and at the end."""
    state: State
    short: bool = False
    """True if the load is still on the forks at the end."""
    robot: bool = False

    @property
    def under(self) -> str | None:
        """Id of the supporting object; None for the ground."""
        found = beneath(Place(self.last), self.state, self.thing)
        return found.id if found else None

    @property
    def slack(self) -> float:
        """Additional tolerance, in metres."""
        return SHORT_M if self.short else 0.0


def ends_well(words: GroundedCommand, nodes: Iterable[int], ending: Ending) -> bool | None:
    """Check an ending against several clauses; None if none of them can be measured."""
    found = [holds for n in nodes if (holds := holds_of(words, n, ending)) is not None]
    return all(found) if found else None


def holds_of(words: GroundedCommand, node: int, ending: Ending) -> bool | None:
    """Check an ending against one clause; None if it can't be measured.

    In the annotated world the annotated region is right, too, regardless of the words.
    """
    places = words.places[node]
    region = _in_region(places, ending)
    if places and not ending.robot and not any(_at_height(p, ending) for p in places):
        region = False
    if words.own and region:
        return True
    related = _related(words, node, ending)
    return region if related is None else related


def _in_region(places: Iterable[Place], ending: Ending) -> bool | None:
    margin = (ROBOT_M if ending.robot else SLACK_M) + ending.slack
    middle = centre(ending.last)
    found = [covers(place.prism, middle, margin) for place in places]
    return any(found) if found else None


def _at_height(place: Place, ending: Ending) -> bool:
    """Check that a place and an ending are both on the ground, or both on a deck."""
    return ending.short or (place.prism.z_min > DECK_M) == (ending.last.z_min > DECK_M)


def _related(words: GroundedCommand, node: int, ending: Ending) -> bool | None:
    """Check an ending against a clause's relation and landmarks; None if unknown."""
    sdc = words.tree.nodes[node]
    if is_there(sdc):
        return None
    if sdc.type == "OBJECT" and not is_area(sdc):
        # "Until you reach the truck" leads to the truck.
        return _measured(_Relation(words, ("to",), (node,), ending))
    marks = words.tree.below(node, ("l", "l2"), "OBJECT", "PLACE")
    nodes = words.tree.nodes
    areas = [n for n in marks if nodes[n].type == "PLACE" or is_area(nodes[n])]
    objects = tuple(n for n in marks if n not in areas)
    if areas:
        inside = _in_areas(words, areas, ending)
        if inside is not None or not objects:
            return inside
    spoken = unstressed(field_words(sdc.relation or sdc.words)) + unplaced(words, objects)
    return _measured(_Relation(words, spoken, objects, ending))


def _in_areas(words: GroundedCommand, areas: list[int], ending: Ending) -> bool | None:
    """Check that an ending lies in an area used as a place: "the ground by the truck"."""
    nodes = words.tree.nodes
    below = (nodes[n] for area in areas for n in words.tree.all_below(area))
    floor = any(FLOOR.intersection(field_words(sdc.words)) for sdc in below)
    if floor and not ending.short and ending.under is not None:
        return False
    telling = [n for n in areas if nodes[n].relation or words.places[n]]
    inside = ends_well(words, telling, ending)
    return True if floor and inside is None else inside


@dataclass(frozen=True)
class _Relation:
    """A relation's words with its landmarks, and where something ends."""

    words: GroundedCommand
    spoken: tuple[str, ...]
    objects: tuple[int, ...]
    ending: Ending

    @cached_property
    def concepts(self) -> frozenset[Concept]:
        return concepts(self.spoken)

    @cached_property
    def sides(self) -> frozenset[Concept]:
        return self.concepts & SIDES

    @cached_property
    def landmarks(self) -> Things:
        """Possible landmarks: allowed things, and annotated ones that haven't moved."""
        words = self.words
        own = (allowed(words, n) | (words.things[n] & words.fixed) for n in self.objects)
        return frozenset[str]().union(*own) - {self.ending.thing}

    @cached_property
    def peers(self) -> Things:
        """Things of the landmarks' kinds, and these."""
        alike = frozenset(i for n in self.objects for i in self.words.alike(n))
        return (self.landmarks | alike) - {self.ending.thing}

    @cached_property
    def regions(self) -> list[Place]:
        return [place for n in self.objects for place in self.words.places[n]]

    @cached_property
    def around(self) -> list[Prism]:
        """The landmarks where they are at the end; the robot is none."""
        things = self.now(self.landmarks - {self.words.robot})
        return things + [place.prism for place in self.regions]

    @cached_property
    def reach(self) -> float:
        return nearest(self.ending.last, self.around) - self.ending.slack

    @property
    def of_robot(self) -> bool:
        nodes = self.words.tree.nodes
        spoken_to = any(names_robot(nodes[n]) for n in self.objects)
        return spoken_to or not self.objects or self.landmarks == {self.words.robot}

    def now(self, ids: Things) -> list[Prism]:
        """Return the shapes of things at the end."""
        return [self.ending.state.thing(i).prism for i in sorted(ids)]


def _measured(relation: _Relation) -> bool | None:
    return next((holds(relation) for applies, holds in _RULES if applies(relation)), None)


def _missing(relation: _Relation) -> bool:
    """Check for a landmark that isn't in this world."""
    words = relation.words
    return any(words.labels[n] and not words.things[n] for n in relation.objects)


def _in(relation: _Relation) -> bool | None:
    # A region without a name is a part of something, to which robots come as to things.
    if relation.ending.robot and not any(place.name for place in relation.regions):
        return relation.reach <= BESIDE_M
    return _in_region(relation.regions, relation.ending)


def _at_end(relation: _Relation) -> bool:
    row = relation.now(relation.peers)
    return relation.reach <= NEAR_M and not is_between(relation.ending.last, row)


def _between(relation: _Relation) -> bool:
    if relation.ending.short and relation.reach <= 0:
        return True
    several = relation.landmarks if len(relation.landmarks) > 1 else relation.peers
    return is_between(relation.ending.last, relation.now(several))


def _on(relation: _Relation) -> bool:
    under = relation.ending.under in relation.landmarks
    return under or (relation.ending.short and relation.reach <= 0)


def _on_side(relation: _Relation) -> bool | None:
    """Check the side of landmarks, for the robot as it stands or as it looks at them.

    A load's side on a deck isn't measured.
    """
    ending, pose = relation.ending, relation.words.state.pose
    if ending.under in relation.landmarks:
        return None
    if ending.short or relation.reach > NEAR_M:
        return relation.reach <= NEAR_M
    [side] = relation.sides
    points = np.array([centre(prism) for prism in relation.around])
    end = centre(ending.last)[None]
    ways = [seen(v, end) - seen(v, points) for v in (pose, looking_at(pose, points))]
    # What is in front of a thing is between it and who looks.
    facing = -1.0 if side in ("front", "back") else 1.0
    return any(_goes(side, facing * way) for way in np.concatenate(ways))


def _near(relation: _Relation) -> bool:
    limit = NEAR_M if relation.concepts & {"far", "last"} else BESIDE_M
    return relation.ending.under in relation.landmarks or relation.reach <= limit


def _aside(relation: _Relation) -> bool | None:
    """Check for a position or a movement to one side of the robot, as the robot sees it."""
    if len(relation.sides) != 1 or relation.ending.short:
        return None
    [side] = relation.sides
    ends = np.array([centre(p) for p in (relation.ending.first, relation.ending.last)])
    first, last = seen(relation.words.state.pose, ends)
    return _goes(side, last) or _goes(side, last - first)


def _goes(side: Concept, way: FloatArray) -> bool:
    ahead, left = (float(x) for x in way)
    return {"front": ahead, "back": -ahead, "left": left, "right": -left}[side] >= TURNS_M


_RULES: tuple[tuple[Callable[[_Relation], bool], Callable[[_Relation], bool | None]], ...] = (
    (_missing, lambda _: False),
    (lambda r: bool(r.regions) and not r.concepts & BESIDE, _in),
    (lambda r: not r.around and r.of_robot, _aside),
    (lambda r: not r.around, lambda _: None),
    (lambda r: bool(ENDS.intersection(r.spoken)), _at_end),
    (lambda r: "between" in r.concepts, _between),
    (lambda r: "on" in r.concepts and not r.sides & {"left", "right"}, _on),
    (lambda r: len(r.sides) == 1, _on_side),
    (lambda r: bool(r.concepts & {"near", "to", "last", "far"}), _near),
)
"""Conditions on a relation, each with its check. The first condition that applies counts."""
