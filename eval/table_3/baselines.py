"""Plans without a model, as baselines for Table 3.

All of them pick up one load. Single words decide the rest: where "put" or the like occurs, the load
is put down; a thing that is named after it is its goal. A command with a verb of going and none of
handling something is driven. They differ in the choice of the load: :func:`nearest`,
:func:`keywords`, :func:`embeddings`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from eval.table_3.grounder_registry import GROUNDERS, PlanTask, grounder
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import CARRY, DRIVE_TO, GO_STRAIGHT, PICK_UP, PUT_DOWN, WAIT
from g3.actions.grounding_candidates import are_free, spots_about, spots_of_robot
from g3.actions.robot_state import State
from g3.geometry.footprints import centre
from g3.groundings import PhysicalObject, Place
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.stemming import stems
from g3.language.lexicon.tables import members, written
from g3.language.similarity import static_embeddings

LEAST_ALIKE = 0.3
"""Smallest cosine at which words may name a label."""
STRAIGHT_M = 4.0
LEFT, RIGHT = (written(members("concept")[side]) for side in ("left", "right"))
PUTTING = stems(["put", "place", "set", "drop"])
BRING = PUTTING | stems(["move", "bring", "carry", "take", "transport", "deliver"])
HANDLE = BRING | stems(["pick", "lift", "load", "grab", "get", "raise"])
GO = stems(word for name in ("going", "turning") for word in written(members("class")[name]))

Things = Sequence[PhysicalObject]
Naming = tuple[Things, int]
"""Things that words name, and the index at which the words end."""
FindNamed = Callable[[Sequence[str], Sequence[tuple[str, ...]], Things], Naming | None]


def _embeddings_missing() -> str:
    return "" if static_embeddings.is_installed() else static_embeddings.MISSING


@grounder("nearest")
def nearest(task: PlanTask) -> list[Action]:
    """Choose the load nearest to the robot, regardless of the words."""
    load = _nearest(task.loads, task.start)
    return _done_with(load, 0, by_label, task)


@grounder("keywords")
def keywords(task: PlanTask) -> list[Action]:
    """Choose the load by the first word that is a label of one.

    Of several loads alike, "left" and "right" take that one, as the robot sees them at the start.
    Else the nearest is taken. Words that are labels of all loads, such as "pallet", decide nothing.
    Where no word is a label, all loads are alike.
    """
    return _by_words(by_label, task)


@grounder("embeddings", missing=_embeddings_missing)
def embeddings(task: PlanTask) -> list[Action]:
    """Choose the load by static word embeddings.

    Each word, and each two words in a row, are compared with the label of each load. The first
    that are at least `LEAST_ALIKE` to one name the load whose label is most like them.
    """
    return _by_words(by_embedding, task)


BASELINES = ("nearest", "keywords", "embeddings")
"""The grounders that every table has. The row `random` is the search with random costs."""


def missing() -> dict[str, str]:
    """Return the baselines that can't be run, with the reasons."""
    lacking = {name: GROUNDERS[name].missing() for name in BASELINES}
    return {name: why for name, why in lacking.items() if why}


def by_label(
    words: Sequence[str], labels: Sequence[tuple[str, ...]], things: Things
) -> Naming | None:
    """Return the things with the first word that is one of their labels."""
    stemmed = [frozenset(map(normalise, own)) for own in labels]
    for place, word in enumerate(map(normalise, words)):
        alike = [thing for thing, own in zip(things, stemmed, strict=True) if word in own]
        if alike:
            return alike, place + 1
    return None


def by_embedding(
    words: Sequence[str], labels: Sequence[tuple[str, ...]], things: Things
) -> Naming | None:
    """Return the things with the label most like the first word or pair like one."""
    texts = [" ".join(own) for own in labels]
    names = sorted({text for text in texts if text})
    if not names:
        return None
    of_names = static_embeddings.vectors(names)
    for place in range(len(words)):
        said = [" ".join(words[place:end]) for end in (place + 1, place + 2) if end <= len(words)]
        alike = static_embeddings.vectors(said) @ of_names.T
        if alike.max() >= LEAST_ALIKE:
            best = names[int(alike.max(axis=0).argmax())]
            return [o for o, text in zip(things, texts, strict=True) if text == best], place + 1
    return None


def _by_words(find: FindNamed, task: PlanTask) -> list[Action]:
    named = find(task.words, _telling(task.loads), task.loads)
    alike, place = named or (task.loads, 0)
    return _done_with(_chosen(alike, task), place, find, task)


def _telling(loads: Things) -> list[tuple[str, ...]]:
    """Return labels of loads without those that all of them have."""
    shared = frozenset[str]()
    if len(loads) > 1:
        shared = frozenset(loads[0].labels).intersection(*(o.labels for o in loads))
    return [tuple(label for label in o.labels if label not in shared) for o in loads]


def _chosen(things: Things, task: PlanTask) -> PhysicalObject | None:
    """Return the left thing, the right one, or the nearest."""
    words = set(task.words)
    if things and (words & LEFT or words & RIGHT):
        x, y, yaw = task.start.pose
        away = np.array([centre(o.prism) for o in things]) - (x, y)
        bearing = np.angle(np.exp(1j * (np.arctan2(away[:, 1], away[:, 0]) - yaw)))
        return things[int(bearing.argmax() if words & LEFT else bearing.argmin())]
    return _nearest(things, task.start)


def _nearest(things: Things, start: State) -> PhysicalObject | None:
    def away(thing: PhysicalObject) -> float:
        return float(np.linalg.norm(centre(thing.prism) - start.pose[:2]))

    return min(things, key=away, default=None)


def _done_with(
    load: PhysicalObject | None, place: int, find: FindNamed, task: PlanTask
) -> list[Action]:
    """Return the actions on a load, whose name ends at a place in the command.

    The list is empty where there is no load and one is required.
    """
    start, verbs = task.start, {normalise(word) for word in task.words}
    if verbs & GO and not verbs & HANDLE:
        return [_driven(find, task)]
    if start.held is not None:
        load = start.thing(start.held)
    if load is None:
        return []
    labels_of = {o.id: labels for o, labels in zip(task.loads, _telling(task.loads), strict=True)}
    things = [o for o in (*task.others, *task.loads) if o.id != load.id]
    goal = find(task.words[place:], [labels_of.get(o.id, o.labels) for o in things], things)
    spot = next(_spots(goal, verbs, load, task), None)
    if spot is not None:
        return [Action(PUT_DOWN if start.held else CARRY, object_id=load.id, place=spot)]
    return [Action(WAIT) if start.held else Action(PICK_UP, object_id=load.id)]


def _driven(find: FindNamed, task: PlanTask) -> Action:
    """Drive to the nearest of the things that are named first, or else straight on."""
    things = [o for o in (*task.loads, *task.others) if o.id != task.start.held]
    named = find(task.words, [o.labels for o in things], things)
    target = _nearest(named[0], task.start) if named else None
    return Action(DRIVE_TO, target=(target,)) if target else Action(GO_STRAIGHT, amount=STRAIGHT_M)


def _spots(
    goal: Naming | None, verbs: set[str], load: PhysicalObject, task: PlanTask
) -> Iterator[Place]:
    """Yield places to put the load, the first choice first; none without a word for putting."""
    spots: list[Place] = []
    if goal and verbs & BRING:
        thing = _chosen(goal[0], task)
        spots += spots_about((thing,), task.start) if thing else []
    elif verbs & PUTTING:
        spots += spots_of_robot(task.start)
    free = are_free(spots, task.start, load.id) if spots else ()
    return (spot for spot, is_free in zip(spots, free, strict=True) if is_free)


GROUNDERS.load_others()
