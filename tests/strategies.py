"""Hypothesis strategies for the domain types."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import get_args

import numpy as np
from hypothesis import strategies as st

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.world.state.recording import Recording, Step
from g3.annotation import RATINGS, SOURCES, Annotation, Command, Judgment, TaskOutcome
from g3.groundings import (
    Aspect,
    Colour,
    Context,
    Grounding,
    Path,
    PhysicalObject,
    Place,
    Prism,
    Trajectory,
)
from g3.sdc.clauses import SDC, SDC_TYPES, Span, breadth_first

words = st.text(min_size=1, max_size=8).filter(
    lambda text: not any(c.isspace() for c in text)
) | st.sampled_from(["the", "pallet", "f", "OBJ", "OBJ_2", "EVENT(", "a@1", '"', "\\", "l2", "="])


def spans(max_start: int = 10_000) -> st.SearchStrategy[Span]:
    """Words at any position."""
    return st.builds(Span, st.integers(0, max_start), words)


def sdc_trees(max_leaves: int = 10) -> st.SearchStrategy[SDC]:
    """Well-formed clauses, with any words at any positions."""
    word_lists = st.lists(spans(), max_size=3).map(tuple)
    types = st.sampled_from(SDC_TYPES)
    leaves = st.builds(SDC, types, words=word_lists) | st.just(SDC("OBJECT"))

    def extend(children: st.SearchStrategy[SDC]) -> st.SearchStrategy[SDC]:
        fields = st.lists(children, max_size=2).map(tuple)
        return st.builds(
            SDC,
            types,
            relation=word_lists,
            figure=fields | st.just((SDC("OBJECT"),)),
            landmark1=fields,
            landmark2=fields,
        )

    return st.recursive(leaves, extend, max_leaves=max_leaves)


def metres(limit: float = 100.0) -> st.SearchStrategy[float]:
    """Coordinates no further than `limit` from the origin."""
    return st.floats(-limit, limit, allow_subnormal=False)


@st.composite
def prisms(draw: st.DrawFn, max_corners: int = 6) -> Prism:
    """Prisms whose footprints are simple polygons with an area, counter-clockwise."""
    k = draw(st.integers(3, max_corners))
    radii = np.array(draw(st.lists(st.floats(0.25, 4.0), min_size=k, max_size=k)))
    angles = 2 * np.pi * np.arange(k) / k + draw(st.floats(0, 1))
    centre = np.array([draw(metres()), draw(metres())])
    xy = centre + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    z_min = draw(st.floats(-1, 2))
    return Prism(xy, z_min, z_min + draw(st.floats(0, 3)))


@st.composite
def trajectories(draw: st.DrawFn, max_poses: int = 5) -> Trajectory:
    """Trajectories of any shape, the times never decreasing."""
    n = draw(st.integers(1, max_poses))
    steps = draw(st.lists(st.floats(0, 10), min_size=n, max_size=n))
    point = st.tuples(metres(), metres(), st.floats(0, 3))
    return Trajectory(
        t=np.cumsum(steps),
        xyz=np.array(draw(st.lists(point, min_size=n, max_size=n))),
        yaw=np.array(draw(st.lists(st.floats(-np.pi, np.pi), min_size=n, max_size=n))),
    )


labels = st.sampled_from(
    [("tire", "pallet"), ("box", "pallet"), ("truck",), ("person",), ("a", "naïve", "label")]
)


def objects(ids: st.SearchStrategy[str] | None = None) -> st.SearchStrategy[PhysicalObject]:
    """Physical objects."""
    return st.builds(
        PhysicalObject,
        id=ids or st.text(min_size=1, max_size=4),
        labels=labels,
        prism=prisms(),
        trajectory=trajectories(),
        liftable=st.sampled_from([None, True, False]),
        colours=st.lists(st.sampled_from(get_args(Colour)), max_size=2, unique=True).map(tuple),
    )


def places() -> st.SearchStrategy[Place]:
    """Places, some with a name."""
    return st.builds(Place, prism=prisms(), name=st.sampled_from(["", "receiving"]))


@st.composite
def contexts(draw: st.DrawFn, name: str = "world", max_objects: int = 4) -> Context:
    """Contexts with one agent and objects whose ids differ."""
    things = draw(st.lists(objects(), min_size=1, max_size=max_objects, unique_by=lambda o: o.id))
    return Context(
        id=name,
        objects=tuple(things),
        places=tuple(draw(st.lists(places(), max_size=2))),
        agent_id=draw(st.sampled_from(things)).id,
    )


@st.composite
def recordings(draw: st.DrawFn, max_moments: int = 6) -> Recording:
    """Recordings of any numbers; objects stand still at many moments, as in real ones."""
    start = draw(contexts(max_objects=3))
    start = replace(
        start,
        objects=tuple(
            replace(item, trajectory=Trajectory(way.t[:1], way.xyz[:1], way.yaw[:1]))
            for item in start.objects
            for way in [item.trajectory]
        ),
    )
    n, b = draw(st.integers(1, max_moments)), len(start.objects)
    pose = st.tuples(*[st.floats(-1e6, 1e6)] * 3, *[st.floats(-1, 1)] * 4)
    values = draw(st.lists(pose, min_size=1, max_size=n * b))
    which = draw(st.lists(st.integers(0, len(values) - 1), min_size=n * b, max_size=n * b))
    poses = np.array(values)[which].reshape(n, b, 7)
    heights = draw(st.lists(st.floats(0, 3), min_size=n, max_size=n))
    times = draw(st.lists(st.integers(0, 10**10), min_size=n, max_size=n, unique=True))
    seconds = st.floats(0, 1e6)
    arguments = st.lists(st.tuples(st.text(max_size=4), st.text(max_size=4)), max_size=2)
    steps = st.builds(Step, st.text(max_size=4), arguments.map(tuple), seconds, seconds)
    return Recording(
        start,
        np.array(sorted(times), dtype=np.int64),
        poses[..., :3].copy(),
        poses[..., 3:].copy(),
        np.array(heights),
        tuple(draw(st.lists(steps, max_size=2))),
    )


def groundings(context: Context) -> st.SearchStrategy[Grounding]:
    """Groundings in a context or outside of it."""
    return st.one_of(
        st.sampled_from(context.objects), objects(), places(), st.builds(Path, trajectories())
    )


def with_text(sdcs: tuple[SDC, ...], separator: str = " ") -> tuple[str, tuple[SDC, ...]]:
    """A command made of the words of the clauses, and the clauses with the words' places."""
    words: list[str] = []

    def place(spans: tuple[Span, ...]) -> Iterator[Span]:
        for span in spans:
            start = sum(map(len, words)) + len(separator) * len(words)
            words.append(span.text)
            yield Span(start, span.text)

    def move(sdc: SDC) -> SDC:
        return replace(
            sdc,
            words=tuple(place(sdc.words)),
            relation=tuple(place(sdc.relation)),
            figure=tuple(map(move, sdc.figure)),
            landmark1=tuple(map(move, sdc.landmark1)),
            landmark2=tuple(map(move, sdc.landmark2)),
        )

    moved = tuple(map(move, sdcs))
    return separator.join(words), moved


@st.composite
def annotations(draw: st.DrawFn, name: str = "a", context: Context | None = None) -> Annotation:
    """Annotations of commands of their own, whose words stand where the clauses say."""
    context = context or draw(contexts())
    text, sdcs = with_text(
        tuple(draw(st.lists(sdc_trees(max_leaves=4), min_size=1, max_size=2))),
        draw(st.sampled_from([" ", "  ", "\r\n"])),
    )
    clauses = sum(1 for _ in breadth_first(sdcs))
    grounded = st.lists(groundings(context), max_size=2).map(tuple)
    labelled = st.sampled_from([True, False, None])
    return Annotation(
        id=f"{name}/annotation",
        command=Command(
            f"{name}/command", text or "Go", draw(st.sampled_from(["s1", "s2"])), "video"
        ),
        context=context,
        sdcs=sdcs,
        groundings=tuple(draw(st.lists(grounded, min_size=clauses, max_size=clauses))),
        correct=tuple(draw(st.lists(labelled, min_size=clauses, max_size=clauses))),
        source=draw(st.sampled_from(SOURCES)),
    )


@st.composite
def judgments(draw: st.DrawFn, name: str = "j") -> Judgment:
    """Judgments."""
    videos = st.sampled_from(["video 1", "video 2"])
    return Judgment(
        id=name,
        command=draw(st.text(min_size=1, max_size=8).filter(str.strip)),
        command_video=draw(videos),
        shown_video=draw(videos),
        rating=draw(st.sampled_from(RATINGS)),
        subject=draw(st.sampled_from(["", "s1", "s2"])),
        study="a study",
    )


@st.composite
def outcomes(draw: st.DrawFn, context: Context, command: Command, name: str = "o") -> TaskOutcome:
    """Outcomes whose parts fit together, of a command or of its video."""
    things = [o.id for o in context.objects if o.id != context.agent_id]
    order = draw(st.permutations(things))
    cut = draw(st.integers(0, len(order)))
    picked, others = tuple(order[:cut]), order[cut:]
    put = draw(st.sampled_from(["on", "ground", "held"])) if picked else ""
    on = draw(st.lists(st.sampled_from(others), unique=True)) if others and put == "on" else []
    unknown = {"on"} if put == "on" and len(on) != 1 else set()
    unknown |= draw(st.sets(st.sampled_from(["place", "rest"])))
    return TaskOutcome(
        id=name,
        scenario=command.scenario,
        context=context.id,
        command=draw(st.sampled_from(["", command.id])),
        video=draw(st.sampled_from(["", command.video])),
        picked=picked,
        put=put,
        on=tuple(on),
        checkpoint=draw(st.none() | st.integers(0, 99)),
        unknown=tuple(sorted(unknown)),
        log=draw(st.text(max_size=4)),
    )


@st.composite
def corpora(draw: st.DrawFn) -> Corpus:
    """Small corpora of one or two contexts; groundings may be another context's objects."""
    worlds = [draw(contexts(name=f"world {i}")) for i in range(draw(st.integers(1, 2)))]
    aspects = st.sampled_from(get_args(Aspect))
    worlds = [
        replace(world, assumed=((world.agent_id, draw(aspects)),) * draw(st.integers(0, 1)))
        for world in worlds
    ]
    annotated = [
        draw(annotations(name=str(i), context=draw(st.sampled_from(worlds))))
        for i in range(draw(st.integers(0, 3)))
    ]
    elsewhere = draw(st.sampled_from(worlds)).objects[0]
    annotated = [
        replace(a, groundings=((*a.groundings[0], elsewhere), *a.groundings[1:])) for a in annotated
    ]
    return Corpus.build(
        draw(st.sampled_from(["a corpus", "corpus-2"])),
        contexts=worlds,
        commands=[a.command for a in annotated],
        annotations=annotated,
        judgments=[draw(judgments(name=str(i))) for i in range(draw(st.integers(0, 2)))],
        outcomes=[
            draw(outcomes(a.context, a.command, name=a.id))
            for a in annotated
            if draw(st.booleans())
        ],
        source="made up",
        licence="none",
    )
