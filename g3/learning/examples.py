"""Labelled factors of annotations: what the model is trained on and evaluated with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from g3 import html_view
from g3.annotation import Annotation, Source
from g3.features.bodies import pack
from g3.features.factor_batch import FactorBatch, FieldWords
from g3.groundings import Context, Grounding, Path, PhysicalObject, Trajectory
from g3.language.lexicon.field_words import field_words, figure_name, figure_words
from g3.sdc.clauses import SDC, SDC_TYPES, Field, all_words, breadth_first, child_indices
from g3.sdc.sdc_drawing import to_svg
from g3.short_repr import short_repr

Groundings = tuple[Grounding, ...]


@short_repr
@dataclass(frozen=True, slots=True)
class Example:
    """One clause with groundings for its factor's arguments, and whether they are right.

    Parameters
    ----------
    annotation
        The annotation of the example.
    node
        Index of the clause in breadth-first order.
    figure, landmark, theme, goal
        Groundings in each role (:data:`g3.features.factor_batch.Role`); empty where there is none.
    words
        Words of the factor's fields.
    correct
        The correspondence variable φ.
    """

    annotation: Annotation
    node: int
    sdc: SDC
    figure: Groundings
    landmark: Groundings
    theme: Groundings
    goal: Groundings
    words: FieldWords = field(repr=False)
    correct: bool

    @property
    def source(self) -> Source:
        """Origin of the groundings."""
        return self.annotation.source

    def _repr_html_(self) -> str:
        """Show the clause, drawn, and its annotation."""
        words = " ".join(w.text for w in all_words(self.sdc))
        right = "right" if self.correct else "wrong"
        about = html_view.heading(f"{self.sdc.type}: {words}", f"clause {self.node + 1}", right)
        return "\n".join([about, to_svg([self.sdc]), self.annotation._repr_html_()])


def examples(annotations: Iterable[Annotation]) -> list[Example]:
    """Every clause that is grounded and labelled, in the order of the annotations.

    A clause without a grounding (the implicit robot of an imperative, an abstract noun)
    or without a label is no example.
    """
    return [example for annotation in annotations for example in _of_annotation(annotation)]


def _of_annotation(annotation: Annotation) -> Iterable[Example]:
    nodes = list(breadth_first(annotation.sdcs))
    children = child_indices(annotation.sdcs)
    for node, (sdc, groundings, correct) in enumerate(
        zip(nodes, annotation.groundings, annotation.correct, strict=True)
    ):
        if not groundings or correct is None:
            continue
        arguments = _Arguments(nodes, children, annotation.groundings, annotation.context)
        event = sdc.type == "EVENT"
        yield Example(
            annotation=annotation,
            node=node,
            sdc=sdc,
            figure=groundings,
            landmark=() if event else arguments.landmark(node),
            theme=arguments.theme(node) if event else (),
            goal=arguments.goal(node) if event else (),
            words=factor_words(sdc),
            correct=correct,
        )


@dataclass(frozen=True, slots=True)
class _Arguments:
    """Finds the groundings that a clause's factor takes from the clauses below it."""

    nodes: Sequence[SDC]
    children: Sequence[dict[Field, tuple[int, ...]]]
    groundings: Sequence[Groundings]
    context: Context

    def _below(self, node: int, fields: tuple[Field, ...], *types: str) -> list[int]:
        return [
            child
            for name in fields
            for child in self.children[node].get(name, ())
            if self.nodes[child].type in types
        ]

    def _things(self, nodes: Iterable[int]) -> Groundings:
        return tuple(g for n in nodes for g in self.groundings[n] if not isinstance(g, Path))

    def landmark(self, node: int) -> Groundings:
        """All landmarks together: "between the truck and the pallet" relates to both."""
        fields: tuple[Field, ...] = ("l", "l2")
        if self.nodes[node].type == "PATH":
            fields = ("f", "l", "l2")
        things = self._things(self._below(node, fields, "OBJECT", "PLACE"))
        if things:
            return things
        return self._things(
            below
            for child in self._below(node, fields, "PATH", "PLACE")
            for below in self._below(child, ("l", "l2"), "OBJECT", "PLACE")
        )

    def theme(self, node: int) -> Groundings:
        """Return the first landmark that is an object other than the agent."""
        for child in self._below(node, ("l", "l2"), "OBJECT"):
            things = tuple(
                g
                for g in self.groundings[child]
                if isinstance(g, PhysicalObject) and g.id != self.context.agent_id
            )
            if things:
                return things
        return ()

    def goal(self, node: int) -> Groundings:
        """Return the event's goal: its PLACE, its PATH's landmark, or a second object."""
        places = self._things(self._below(node, ("l", "l2"), "PLACE"))
        if places:
            return places
        for child in self._below(node, ("l", "l2"), "PATH", "PLACE"):
            things = self.landmark(child)
            if things:
                return things
        objects = self._below(node, ("l", "l2"), "OBJECT")
        return self._things(objects[1:])


def factor_words(sdc: SDC) -> FieldWords:
    """Words of the fields that a clause's factor sees."""
    goal = (
        span
        for child in (*sdc.landmark1, *sdc.landmark2)
        if sdc.type == "EVENT" and child.type in ("PATH", "PLACE")
        for span in child.relation
    )
    named = sdc.type in ("OBJECT", "PLACE")
    return {
        "figure": figure_words(sdc) if named else (),
        "name": figure_name(sdc) if named else (),
        "relation": field_words(sdc.relation),
        "goal": field_words(goal),
        "landmark": field_words(
            span for child in (*sdc.landmark1, *sdc.landmark2) for span in all_words(child)
        ),
    }


def to_batch(items: Sequence[Example]) -> FactorBatch:
    """Pack examples for feature extraction; groundings and words that several share are once."""
    groups: list[Groundings] = []
    seen: dict[tuple[int, ...], int] = {}

    def body(group: Groundings) -> int:
        if not group:
            return -1
        key = tuple(id(g) for g in group)
        if key not in seen:
            seen[key] = len(groups)
            groups.append(group)
        return seen[key]

    roles = {
        role: np.array([body(getattr(e, role)) for e in items], dtype=np.intp)
        for role in ("figure", "landmark", "theme", "goal")
    }
    contexts = {id(e.annotation.context): e.annotation.context for e in items}
    row_of = {key: i for i, key in enumerate(contexts)}
    peers = [
        [body((o,)) for o in context.objects if o.id != context.agent_id]
        for context in contexts.values()
    ]
    width = max((len(p) for p in peers), default=0)
    padded = np.array([p + [-1] * (width - len(p)) for p in peers], dtype=np.intp)
    agents = np.array([body((c.agent,)) for c in contexts.values()], dtype=np.intp)
    poses = np.array([_agent_poses(c.agent.trajectory) for c in contexts.values()]).reshape(-1, 5)
    phrases: dict[tuple[object, ...], int] = {}
    factor = [phrases.setdefault(tuple(e.words.items()), len(phrases)) for e in items]
    words: dict[int, FieldWords] = {}
    for i, e in zip(factor, items, strict=True):
        words.setdefault(i, e.words)
    context = np.array([row_of[id(e.annotation.context)] for e in items], dtype=np.intp)
    return FactorBatch(
        bodies=pack(groups),
        type=np.array([SDC_TYPES.index(e.sdc.type) for e in items], dtype=np.int8),
        agent=poses[context, :3],
        agent_end_yaw=poses[context, 3],
        agent_mean_yaw=poses[context, 4],
        agent_body=agents[context],
        peers=padded.reshape(len(contexts), width)[context],
        factor=np.array(factor, dtype=np.intp),
        words=list(words.values()),
        **roles,
    )


def labels(items: Sequence[Example]) -> npt.NDArray[np.bool_]:
    """Return the correspondence variables of examples, shape (n,)."""
    return np.array([e.correct for e in items], dtype=bool)


def _agent_poses(trajectory: Trajectory) -> tuple[float, float, float, float, float]:
    """Start x, y, yaw; end yaw; mean yaw (as a direction)."""
    yaw = trajectory.yaw
    mean = np.arctan2(np.sin(yaw).mean(), np.cos(yaw).mean())
    x, y = trajectory.xyz[0, :2]
    return float(x), float(y), float(yaw[0]), float(yaw[-1]), float(mean)
