"""Whether something ends where a PLACE's or a PATH's words allow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from eval.judging.allowed_things import BESIDE_M, NEAR_M, allowed, unplaced
from eval.judging.layout import is_between, looking_at, nearest, seen
from eval.judging.worded import Worded
from g3.actions.grounding_candidates import beneath
from g3.actions.logged_actions import centre, covers
from g3.actions.robot_state import State
from g3.groundings import FloatArray, Place, Prism
from g3.inference.problem.phrases import is_area, is_there, names_robot, told
from g3.language.lexicon.concepts import Concept, concepts
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.word_sets import ENDS, FLOOR

SLACK_M = 0.5
"""What ends no further outside of an annotated region is in it."""
SHORT_M = 4.0
"""A load that is still on the forks may be so much further from where it belongs."""
TURNS_M = 0.7
"""What is to go to a side goes at least so far that way."""


@dataclass(frozen=True, slots=True)
class Ending:
    """Where something comes to.

    Parameters
    ----------
    thing
        Its id.
    first, last
        Its shape where it starts and where it ends.
    state
        The world when it ends there.
    short
        Whether it is a load that is on the forks still.
    """

    thing: str
    first: Prism
    last: Prism
    state: State
    short: bool = False

    @property
    def under(self) -> str | None:
        """Id of what it stands on; None for the ground."""
        found = beneath(Place(self.last), self.state, self.thing)
        return found.id if found else None

    @property
    def slack(self) -> float:
        """Metres that it may be further off."""
        return SHORT_M if self.short else 0.0


def ends_well(words: Worded, nodes: Iterable[int], ending: Ending) -> bool | None:
    """Whether something ends where several clauses say together; None if none can be measured."""
    found = [holds for n in nodes if (holds := holds_of(words, n, ending)) is not None]
    return all(found) if found else None


def holds_of(words: Worded, node: int, ending: Ending) -> bool | None:
    """Whether something ends where a clause says; None if that can't be measured.

    In the world that was annotated its region is right, too, whatever the words.
    """
    region = _in_region(words.places[node], ending)
    if words.own and region:
        return True
    related = _related(words, node, ending)
    return region if related is None else related


def _in_region(places: Iterable[Place], ending: Ending) -> bool | None:
    margin = SLACK_M + ending.slack
    middle = centre(ending.last)
    found = [
        covers(p.prism, middle, margin)
        and (ending.short or (p.prism.z_min > _HIGH_M) == (ending.last.z_min > _HIGH_M))
        for p in places
    ]
    return any(found) if found else None


_HIGH_M = 0.4
"""Between the ground and the decks of vehicles."""


def _related(words: Worded, node: int, ending: Ending) -> bool | None:
    tree = words.tree
    sdc = tree.nodes[node]
    if is_there(sdc):
        return None
    spoken = told(field_words(sdc.relation or sdc.words))
    marks = tree.below(node, ("l", "l2"), "OBJECT", "PLACE")
    areas = [n for n in marks if tree.nodes[n].type == "PLACE" or is_area(tree.nodes[n])]
    objects = [n for n in marks if n not in areas]
    named = concepts((*spoken, *unplaced(words, objects)))
    if areas:
        inner = ends_well(words, [n for n in areas if _says_where(words, n)], ending)
        floor = any(FLOOR.intersection(field_words(tree.nodes[n].words)) for n in _leaves(words, areas))
        if floor and not ending.short and ending.under is not None:
            return False
        if inner is not None or not objects:
            return inner if inner is not None else (True if floor else None)
    if any(words.labels[n] and not words.things[n] for n in objects):
        return False
    landmarks = frozenset(i for n in objects for i in _landmarks(words, n)) - {ending.thing}
    spoken_to = any(names_robot(tree.nodes[n]) for n in objects) or landmarks == {words.robot}
    around = prisms_now(ending.state, landmarks - {words.robot})
    if not around:
        return _aside(named, words, ending) if spoken_to or not objects else None
    reach = nearest(ending.last, around) - ending.slack
    peers = frozenset(i for n in objects for i in words.alike(n)) - {ending.thing}
    if ENDS.intersection(field_words(sdc.relation)):
        row = prisms_now(ending.state, landmarks | peers)
        return reach <= NEAR_M and not is_between(ending.last, row)
    if "between" in named:
        several = landmarks if len(landmarks) > 1 else landmarks | peers
        return ending.short and reach <= 0 or is_between(
            ending.last, prisms_now(ending.state, several)
        )
    if "on" in named and not named & {"left", "right"}:
        return ending.under in landmarks or (ending.short and reach <= 0)
    sides = named & {"left", "right", "front", "back"}
    if len(sides) == 1:
        [side] = sides
        if ending.under in landmarks:
            return None
        return reach <= NEAR_M and (ending.short or _on_side(side, words, ending, around))
    if named & {"near", "to", "last", "far"}:
        limit = NEAR_M if named & {"far", "last"} else BESIDE_M
        return ending.under in landmarks or reach <= limit
    return None


def _landmarks(words: Worded, node: int) -> frozenset[str]:
    """Things that a landmark may be: what it was annotated with, too, if that hasn't moved."""
    return allowed(words, node) | (words.things[node] & words.fixed)


def prisms_now(state: State, ids: frozenset[str]) -> list[Prism]:
    """Where things are in a state."""
    return [state.thing(i).prism for i in sorted(ids)]


def _leaves(words: Worded, nodes: Iterable[int]) -> list[int]:
    return [n for node in nodes for n in words.tree.all_below(node)]


def _says_where(words: Worded, node: int) -> bool:
    sdc = words.tree.nodes[node]
    return bool(sdc.relation) or bool(words.places[node])


def _aside(named: frozenset[Concept], words: Worded, ending: Ending) -> bool | None:
    """Whether something goes to a side of the robot, or of where it was, as the robot sees it."""
    sides = named & {"left", "right", "front", "back"}
    if len(sides) != 1 or ending.short:
        return None
    pose = words.state.pose
    first, last = seen(pose, np.array([centre(ending.first), centre(ending.last)]))
    return any(_goes(next(iter(sides)), v) for v in (last, last - first))


def _goes(side: Concept, way: FloatArray) -> bool:
    ahead, left = (float(x) for x in way)
    return {"front": ahead, "back": -ahead, "left": left, "right": -left}[side] >= TURNS_M


def _on_side(side: Concept, words: Worded, ending: Ending, around: list[Prism]) -> bool:
    """Whether it is on that side of landmarks, for the robot as it stands or as it looks at them."""
    points = np.array([centre(p) for p in around])
    end = centre(ending.last)
    for view in (words.state.pose, looking_at(words.state.pose, points)):
        place = seen(view, end[None])[0] - seen(view, points)
        if any(_goes(side, -v if side in ("front", "back") else v) for v in place):
            return True
    return False
