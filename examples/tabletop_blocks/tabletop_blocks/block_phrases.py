"""Commands for a hand's tasks, with their trees and the groundings of each clause."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from g3.groundings import Grounding, PhysicalObject
from g3.sdc.clauses import SDCType
from tabletop_blocks.block_scenes import Task, is_on

PUT_VERBS = ("Put", "Place", "Set", "Move")
STACK_VERBS = ("Put", "Place", "Stack", "Set")
LIFT_VERBS = ("Pick up", "Lift", "Take", "Grab")
TOUCH_VERBS = ("Go", "Move", "Reach")
RELATIONS = {
    "on": ("on", "on top of", "onto"),
    "in": ("in", "into", "on"),
    "left of": ("to the left of", "left of"),
    "right of": ("to the right of", "right of"),
    "behind": ("behind", "in back of"),
    "in front of": ("in front of", "before"),
}
SYNONYMS = {"block": ("block", "cube"), "bar": ("bar", "brick"), "tray": ("tray",)}


@dataclass(frozen=True, slots=True)
class Phrase:
    """A clause in words.

    Parameters
    ----------
    type
        Type of the clause.
    relation
        Its words; empty in a leaf.
    words
        A leaf's words.
    figure, landmarks
        Clauses in it.
    groundings
        Groundings of the clause.
    """

    type: SDCType
    groundings: tuple[Grounding, ...]
    relation: str = ""
    words: str = ""
    figure: Phrase | None = None
    landmarks: tuple[Phrase, ...] = ()

    @property
    def text(self) -> str:
        """The words."""
        parts = (self.figure.text if self.figure else "", self.relation, self.words)
        return " ".join([*filter(None, parts), *(p.text for p in self.landmarks)])

    @property
    def notation(self) -> str:
        """The clause in the notation of the paper's figures."""
        name = "OBJ" if self.type == "OBJECT" else self.type
        if self.words:
            return f"{name}(f = {self.words})"
        fields = [f"f = {self.figure.notation}"] if self.figure else []
        fields += [f"r = {self.relation}"] if self.relation else []
        marks = zip(("l", "l2"), self.landmarks, strict=False)
        fields += [f"{field} = {mark.notation}" for field, mark in marks]
        return f"{name}({', '.join(fields)})"

    def children(self) -> Sequence[tuple[Grounding, ...] | Phrase]:
        """Return the clauses in it; the robot, which nobody names, has no grounding."""
        robot: list[tuple[Grounding, ...] | Phrase] = [()] if self.type == "EVENT" else []
        return [*robot, *([self.figure] if self.figure else []), *self.landmarks]


def groundings_of(phrase: Phrase) -> tuple[tuple[Grounding, ...], ...]:
    """Return the groundings of each clause, breadth first."""
    level: list[tuple[Grounding, ...] | Phrase] = [phrase]
    found: list[tuple[Grounding, ...]] = []
    while level:
        found += [item.groundings if isinstance(item, Phrase) else item for item in level]
        level = [c for item in level if isinstance(item, Phrase) for c in item.children()]
    return tuple(found)


def commands_for(task: Task, count: int, rng: np.random.Generator) -> Iterator[Phrase]:
    """Yield different commands for a task; none where its things can't be distinguished."""
    seen: set[str] = set()
    for _ in range(8 * count):
        phrase = _command(task, rng)
        if phrase is not None and phrase.text not in seen and len(seen) < count:
            seen.add(phrase.text)
            yield phrase


def _command(task: Task, rng: np.random.Generator) -> Phrase | None:
    theme = _object(task, task.theme, rng)
    if theme is None:
        return None
    hand = (task.context.agent,)
    if task.relation == "up":
        return Phrase("EVENT", hand, _one(LIFT_VERBS, rng), landmarks=(theme,))
    if task.relation == "to":
        path = Phrase("PATH", (task.path,), "to", landmarks=(theme,))
        return Phrase("EVENT", hand, _one(TOUCH_VERBS, rng), landmarks=(path,))
    if task.landmark is None or task.place is None:
        return None
    landmark = _object(task, task.landmark, rng)
    if landmark is None:
        return None
    relation = _one(RELATIONS[task.relation], rng)
    place = Phrase("PLACE", (task.place,), relation, landmarks=(landmark,))
    verbs = STACK_VERBS if task.relation == "on" else PUT_VERBS
    return Phrase("EVENT", hand, _one(verbs, rng), landmarks=(theme, place))


def _object(task: Task, thing: PhysicalObject, rng: np.random.Generator) -> Phrase | None:
    """Return a phrase that fits one thing alone: by its colour, or by the thing below it."""
    shape = thing.labels[-1]
    alike = [o for o in task.context.objects if o.labels == thing.labels]
    same_shape = [o for o in task.context.objects if o.labels[-1] == shape]
    noun = _one(SYNONYMS[shape], rng)
    below = [o for o in task.context.objects if is_on(thing, o) and o.labels != ("table",)]
    if below and (len(alike) > 1 or rng.random() < 0.3):
        rivals = [o for o in same_shape if o is not thing and is_on(o, below[0])]
        landmark = _leaf(task, below[0], rng)
        if landmark is not None and not rivals:
            figure = Phrase("OBJECT", (thing,), words=f"the {noun}")
            return Phrase("OBJECT", (thing,), "on", figure=figure, landmarks=(landmark,))
    return _leaf(task, thing, rng)


def _leaf(task: Task, thing: PhysicalObject, rng: np.random.Generator) -> Phrase | None:
    if sum(o.labels == thing.labels for o in task.context.objects) > 1:
        return None
    noun = _one(SYNONYMS[thing.labels[-1]], rng)
    return Phrase("OBJECT", (thing,), words=" ".join(("the", *thing.labels[:-1], noun)))


def _one(choices: Sequence[str], rng: np.random.Generator) -> str:
    return choices[int(rng.integers(len(choices)))]
