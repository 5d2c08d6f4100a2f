"""Hard negatives: wrong groundings that the robot might really consider for a command.

A random grounding from another log is easily distinguished from the right one (section 4.1): its
path starts elsewhere, its objects are of another scene. Hard negatives come from the command's own
scene and start state. Each positive annotation gives

``<id>/hard-action-0``, ``-1``, …
    One for every EVENT, and for every PATH outside of one: it gets a candidate action,
    which the clauses below it share: they are grounded to what the agent does then and
    labelled False. OBJECTs and PLACEs keep their right groundings, for they are landmarks
    of these factors, and have no label. They, and all objects of the context, have the
    trajectories that the action gives them.
``<id>/hard-objects-0``, ``-1`` and ``-2``
    Other candidates of the same scene for the OBJECTs and PLACEs whose depth in the tree
    leaves this rest when divided by three; the other clauses stay as annotated, without
    a label. A factor's landmarks are one or two levels below it, so they stay right.

Where no candidate is surely wrong the clause gets no label.
"""

from __future__ import annotations

import hashlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from g3.actions.action_kinds import Action, Focus, move, outcomes, possible_actions
from g3.actions.forklift_actions import WAIT
from g3.actions.grounding_candidates import (
    are_free,
    beneath,
    footprint_of,
    ground,
    is_surface,
    spots_about,
)
from g3.actions.logged_actions import (
    Handling,
    Outcome,
    at_rest,
    end_of,
    handling,
    moved,
    path_length,
    recorded,
)
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.features.sets.order import is_ordinal
from g3.geometry.footprints import apart, centre
from g3.geometry.plane import convex_hull, point_gap, rotate, wrap
from g3.geometry.relations import OTHER_PLACE_M
from g3.groundings import Context, FloatArray, Grounding, Path, PhysicalObject, Place, Prism
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import field_words, normalise
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC, Field, all_words, breadth_first, child_indices
from g3.short_repr import short_repr

ELSEWHERE_M = 3.0
"""A load put down this far from where the log puts it is somewhere else."""
AWAY_M = 4.0
"""So is an agent that ends this far from where the log ends."""
AT_M = 3.0
"""Distance from a thing's border within which the agent may count as being there."""
LOAD_AT_M = 2.0
"""Distance from a border within which the middle of a load may count as being there."""
PASSING_M = 2.0
OTHER_WAY_RAD = np.pi / 4

Thing = PhysicalObject | Place

Labels = tuple[str, ...]
Usage = Mapping[tuple[str, ...], frozenset[Labels]]
"""For the words of an OBJECT, the labels of everything that they are ever right for."""

ANOTHER_PLACE_M = 3.0
SAME_LABELS = 0.5
"""Share of candidates for OBJECTs that are drawn from those alike, where there are some."""
SAME_HEIGHT = 0.75
"""Share of candidates for places drawn from those about as high as the right one."""


@short_repr
@dataclass(frozen=True, slots=True)
class Clause:
    """A clause of a positive annotation and what is grounded in it.

    Parameters
    ----------
    things
        Objects and places grounded anywhere below it, without the agent.
    landmarks
        Those of them below its landmark fields.
    themes
        Objects that are direct landmarks of it, without the agent.
    """

    sdc: SDC
    groundings: tuple[Grounding, ...]
    things: tuple[Thing, ...]
    landmarks: tuple[Thing, ...]
    themes: tuple[PhysicalObject, ...]
    context: Context

    @staticmethod
    def of(annotation: Annotation, node: int) -> Clause:
        """Look a clause up by its index in breadth-first order."""
        nodes = list(breadth_first(annotation.sdcs))
        children = child_indices(annotation.sdcs)
        direct = [c for field in ("l", "l2") for c in children[node].get(field, ())]
        figures = children[node].get("f", ())
        landmarks = _things(annotation, below(children, direct))
        themes = _things(annotation, (n for n in direct if nodes[n].type == "OBJECT"))
        return Clause(
            nodes[node],
            annotation.groundings[node],
            (*_things(annotation, below(children, figures)), *landmarks),
            landmarks,
            tuple(g for g in themes if isinstance(g, PhysicalObject)),
            annotation.context,
        )


def below(children: Sequence[Mapping[Field, tuple[int, ...]]], nodes: Iterable[int]) -> list[int]:
    """Return some clauses and all clauses below them."""
    reached = list(nodes)
    for n in reached:
        reached.extend(c for group in children[n].values() for c in group)
    return reached


def _things(annotation: Annotation, nodes: Iterable[int]) -> tuple[Thing, ...]:
    agent = annotation.context.agent_id
    return tuple(
        g
        for n in nodes
        for g in annotation.groundings[n]
        if not isinstance(g, Path) and not (isinstance(g, PhysicalObject) and g.id == agent)
    )


def is_wrong(clause: Clause, log: Outcome, action: Outcome) -> bool:
    """Check that an action can't be meant by an EVENT or PATH that a log is right for.

    An EVENT about an object that the log moves is about that object: an action is wrong
    if it leaves the object alone or, where the clause says where to, takes it elsewhere.
    All others are about where the agent goes.
    """
    themes = {g.id for g in clause.themes} & moved(log) if clause.sdc.type == "EVENT" else set()
    if not themes:
        return _goes_elsewhere(clause, log, action)
    if not themes & moved(action):
        return True
    return all(_put_elsewhere(clause, theme, log, action) for theme in sorted(themes))


def other_actions(tried: Sequence[Action], right: Action, state: State) -> list[Action]:
    """Return the actions in a state that a clause can't mean, where that is known.

    Search gives each clause an action of its own, where the corpus gives all clauses of a command
    the whole log. So an action is wrong too that handles another load, handles it in another way,
    or leads elsewhere, for any words of the clause.

    Parameters
    ----------
    right
        Meaning of the clause. If it drives, its target is where it ends.
    """
    if right.kind.handles:
        return [a for a in tried if _handles_otherwise(a, right)]
    drives = [a for a in tried if a.kind is not WAIT and not a.kind.handles]
    ends = move(state, drives).xyz[:, -1, :2] if drives else np.zeros((0, 2))
    goal = footprint_of(right.target).mean(axis=0)
    near = np.linalg.norm(ends - goal, axis=1) <= AWAY_M
    left_out = {id(a) for a, is_near in zip(drives, near, strict=True) if is_near}
    return [a for a in tried if id(a) not in left_out]


def _handles_otherwise(action: Action, right: Action) -> bool:
    if action.kind is not right.kind or action.object_id != right.object_id:
        return True
    if action.place is None or right.place is None:
        return False
    return apart(action.place.prism, right.place.prism) > OTHER_PLACE_M


def _put_elsewhere(clause: Clause, theme: str, log: Outcome, action: Outcome) -> bool:
    """Check that a load ends away from its end in the log, and from its named landmark."""
    before, after = (
        end_of(next(o for o in outcome.objects if o.id == theme)) for outcome in (log, action)
    )
    goals = [
        thing
        for thing in clause.things
        if not (isinstance(thing, PhysicalObject) and thing.id == theme)
        and _gap(before, thing) < LOAD_AT_M
    ]
    far = float(np.linalg.norm(after - before)) > ELSEWHERE_M
    return bool(goals) and far and all(_gap(after, goal) > LOAD_AT_M for goal in goals)


def _goes_elsewhere(clause: Clause, log: Outcome, action: Outcome) -> bool:
    """Check that the agent ends elsewhere than in the log, not at the named thing."""
    path = action.agent.trajectory.xyz[:, :2]
    before = log.agent.trajectory.xyz[-1, :2]
    if float(np.linalg.norm(path[-1] - before)) <= AWAY_M:
        return False
    if not clause.things:
        return _goes_another_way(log, action)
    for thing in clause.things:
        if _gap(path[-1], thing) <= AT_M:
            return False
        only_passed = _gap(before, thing) > AWAY_M
        if only_passed and _gaps(path, thing).min() <= PASSING_M:
            return False
    return True


def _goes_another_way(log: Outcome, action: Outcome) -> bool:
    """Check that the agent ends in another direction from the start than in the log."""

    def bearing(outcome: Outcome) -> float:
        track = outcome.agent.trajectory
        net = rotate(track.xyz[-1, :2] - track.xyz[0, :2], -track.yaw[0])
        return float(np.arctan2(net[1], net[0]))

    return bool(abs(wrap(np.array(bearing(log) - bearing(action)))) > OTHER_WAY_RAD)


def _gap(point: FloatArray, thing: Thing) -> float:
    """Distance in metres from a point to a footprint, at the thing's first pose."""
    return float(_gaps(point[None], thing)[0])


def _gaps(points: FloatArray, thing: Thing) -> FloatArray:
    """Return the distances from points (n, 2) to a footprint, in metres."""
    gaps: FloatArray = point_gap(points[None], convex_hull(thing.prism.xy)[None])[0]
    return gaps


def usage(positives: Iterable[Annotation]) -> Usage:
    """Return the labels for which the words of positive OBJECTs are used."""
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
    """Draw as many wrong groundings as an OBJECT or PLACE clause has right ones, if there are any.

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
        candidates = _other_places(clause, places)
        level = [p for p in candidates if abs(p.prism.z_min - places[0].prism.z_min) < 0.3]
        uneven = [p for p in candidates if abs(p.prism.z_min - places[0].prism.z_min) >= 0.3]
        first, second = (level, uneven) if rng.random() < SAME_HEIGHT else (uneven, level)
        return _draw(first or second, len(places), rng)
    return ()


def _draw(
    candidates: Sequence[Grounding], count: int, rng: np.random.Generator
) -> tuple[Grounding, ...]:
    chosen = rng.permutation(len(candidates))[:count]
    return tuple(candidates[i] for i in chosen)


def _wording(sdc: SDC) -> tuple[str, ...]:
    return tuple(sorted(set(field_words(all_words(sdc))) - WORDS["determiners"]))


def tells_apart(clause: Clause) -> bool:
    """Check that an OBJECT's words name more than a kind of thing: its position, its order.

    "The pallet of boxes" names a kind, for its landmark is what it is made of.
    """
    right_ids = {g.id for g in clause.groundings if isinstance(g, PhysicalObject)}
    landmarks = [g.id if isinstance(g, PhysicalObject) else None for g in clause.landmarks]
    if not clause.sdc.is_leaf and not (landmarks and right_ids.issuperset(landmarks)):
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
    """Return the spots that a PLACE surely doesn't mean: far from all that is right."""
    things = [g for g in right if not isinstance(g, Path)]
    return [s for s in spots if all(apart(s.prism, thing.prism) > metres for thing in things)]


def _other_places(clause: Clause, right: Sequence[Place]) -> list[Place]:
    """Move the right place to where another might be, so that its shape gives nothing away.

    Elsewhere than on what it is on, and not beside what the clause names.
    """
    state, model = start_state(clause.context), right[0]
    support = beneath(model, state, None)
    height = model.prism.z_min - _top(support, state)
    named = {g.id for g in clause.things if isinstance(g, PhysicalObject)}
    spots = [(place, beneath(place, state, None)) for place in state.context.places]
    for thing in recorded(state.context).objects:
        about = ((spot, beneath(spot, state, None)) for spot in spots_about((thing,), state))
        spots += [(spot, on) for spot, on in about if on is not None or thing.id not in named]
    places_left = [
        Place(_shifted(model.prism, centre(spot.prism), _top(on, state) + height))
        for spot, on in spots
        if on is None or on is not support
    ]
    far = far_places(places_left, right, ANOTHER_PLACE_M)
    return [p for p, free in zip(far, are_free(far, state, None), strict=True) if free]


def _top(thing: PhysicalObject | None, state: State) -> float:
    return ground(state) if thing is None else thing.prism.z_max


def _shifted(prism: Prism, middle: FloatArray, bottom: float) -> Prism:
    xy = prism.xy + middle - centre(prism)
    return Prism(xy, bottom, bottom + (prism.z_max - prism.z_min))


OWN_HANDLING = 0.5
"""Share of the actions that do to a load what the log does."""
FLOOR = 0.15
"""Share of the other actions that is drawn evenly from all possible effects on a load. The rest is
drawn as in the positives, lest it give the label away."""
CHOICES = 4
"""Wrong actions that are compared for the length of their paths."""
TRIES = 16
"""Actions that are tried before others that do something else to a load."""
RAISED_M = 0.5
"""Places with their bottom higher than this are on something."""
SHORTEST_M = 0.1
"""Paths shorter than this are as good as none."""
DEPTHS = 3

Groundings = tuple[Grounding, ...]


def hard_negatives(annotations: Sequence[Annotation], rng: np.random.Generator) -> list[Annotation]:
    """Make hard negatives from the positive annotations of a corpus.

    The result for an annotation depends on its id and on one draw from the generator, not on the
    order of the annotations; on the others only through how often each kind of action is seen,
    which things are ever moved, and which objects each wording is ever used for.

    Parameters
    ----------
    annotations
        Annotations of any source; only the positives count.

    Returns
    -------
    list
        Annotations with source ``hard``; none without a labelled clause.
    """
    positives = [a for a in annotations if a.source == "positive"]
    seed = int(rng.integers(2**32))
    contexts = {id(a.context): a.context for a in positives}
    movable = {
        label
        for context in contexts.values()
        for o in recorded(context).objects
        if o.id in moved(recorded(context))
        for label in o.labels
    }
    scenes = {key: _scene(context, movable) for key, context in contexts.items()}
    seen = Counter(scenes[id(a.context)].handling for a in positives)
    words = usage(positives)
    made: list[Annotation] = []
    for annotation in positives:
        generator = np.random.default_rng([seed, _number(annotation.id)])
        made.extend(_hard_actions(annotation, scenes[id(annotation.context)], seen, generator))
        made.extend(_hard_things(annotation, words, depth, generator) for depth in range(DEPTHS))
    return [a for a in made if any(label is not None for label in a.correct)]


def _number(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")


@dataclass(frozen=True, slots=True)
class _Scene:
    """A context, what its log did, and what else could be done, by what it does to a load."""

    state: State
    log: Outcome
    handling: Handling
    actions: Mapping[Handling, Sequence[Action]]


def _scene(context: Context, movable: Iterable[str]) -> _Scene:
    state = start_state(context)
    possible: dict[Handling, list[Action]] = {}
    for action in possible_actions(state, _everything(state, frozenset(movable))):
        possible.setdefault(action.kind.handling, []).append(action)
    return _Scene(state, recorded(context), handling(context), possible)


def _everything(state: State, movable: frozenset[str]) -> Focus:
    """All that a command may be about in a state."""
    things = recorded(state.context).objects
    loads = (o.id for o in things if movable.intersection(o.labels))
    goals: list[Groundings] = [(place,) for place in state.context.places]
    goals += [(o,) for o in things if is_surface(o)]
    marks: list[Groundings] = [(o,) for o in things if not is_surface(o)]
    return Focus(tuple(loads), tuple(goals), landmarks=tuple(marks))


def _hard_actions(
    annotation: Annotation, scene: _Scene, seen: Mapping[Handling, int], rng: np.random.Generator
) -> list[Annotation]:
    """Draw a candidate action for each top EVENT and PATH, in the scene that it changes."""
    nodes, children = list(breadth_first(annotation.sdcs)), child_indices(annotation.sdcs)
    made: list[Annotation] = []
    for root in _roots(annotation.sdcs):
        tree = below(children, [root])
        acts = [n for n in tree if nodes[n].type in ("EVENT", "PATH") and _is_right(annotation, n)]
        other = _wrong_action(annotation, acts, scene, seen, rng) if acts else None
        if other is None:
            continue
        groundings: list[Groundings] = [()] * len(nodes)
        correct: list[bool | None] = [None] * len(nodes)
        for n in tree:
            if nodes[n].type not in ("EVENT", "PATH"):
                groundings[n] = _after(annotation.groundings[n], other)
            elif n in acts:
                act = other.agent if nodes[n].type == "EVENT" else Path(other.agent.trajectory)
                groundings[n] = (act,)
                wrong = is_wrong(Clause.of(annotation, n), scene.log, other)
                correct[n] = False if wrong else None
        made.append(
            replace(
                annotation,
                id=f"{annotation.id}/hard-action-{len(made)}",
                context=replace(annotation.context, objects=(other.agent, *other.objects)),
                groundings=tuple(groundings),
                correct=tuple(correct),
                source="hard",
            )
        )
    return made


def _wrong_action(
    annotation: Annotation,
    acts: Sequence[int],
    scene: _Scene,
    seen: Mapping[Handling, int],
    rng: np.random.Generator,
) -> Outcome | None:
    """Draw an action that is wrong for as many of some clauses as can be, at least for one.

    The kinds are tried in an order drawn by their weights. Among a few wrong actions of
    a kind that whose path is about as long as the log's is taken.
    """
    clauses = [Clause.of(annotation, n) for n in acts]
    length = max(path_length(scene.log), SHORTEST_M)
    orders = (order for h in _handlings(scene, seen, rng) for order in _orders(scene, h, rng))
    for order in orders:
        tried: list[tuple[int, float, Outcome]] = []
        for done in outcomes(scene.state, order[:TRIES]):
            wrong = sum(is_wrong(clause, scene.log, done) for clause in clauses)
            if wrong:
                unlike = abs(np.log(max(path_length(done), SHORTEST_M) / length))
                tried.append((-wrong, unlike, done))
            if sum(-w == len(clauses) for w, _, _ in tried) == CHOICES:
                break
        if tried:
            return min(tried, key=lambda t: t[:2])[2]
    return None


def _handlings(
    scene: _Scene, seen: Mapping[Handling, int], rng: np.random.Generator
) -> list[Handling]:
    """Return possible effects on a load, in an order drawn by their frequency in logs."""
    possible = list(scene.actions)
    counts = np.array([seen.get(one, 0) for one in possible], dtype=float)
    share = counts / max(counts.sum(), 1.0)
    weights = (1 - FLOOR) * share + FLOOR / len(possible)
    weights *= (1 - OWN_HANDLING) / weights.sum()
    weights += OWN_HANDLING * np.array([one == scene.handling for one in possible])
    order = rng.choice(len(possible), len(possible), replace=False, p=weights / weights.sum())
    return [possible[i] for i in order]


def _orders(scene: _Scene, done: Handling, rng: np.random.Generator) -> list[list[Action]]:
    """Random orders of the actions that do something, about the log's object and about others.

    The order is drawn too: the right object in a wrong place is harder than another object.
    Raised places come as often as the floor, for trucks offer few places and the floor many, but
    things are put on trucks as often.
    """
    about = moved(scene.log)
    groups: tuple[list[Action], list[Action]] = ([], [])
    for action in scene.actions[done]:
        groups[action.object_id not in about].append(action)
    first = int(rng.integers(2))
    orders: list[list[Action]] = []
    for group in (groups[first], groups[1 - first]):
        raised = [a.place is not None and a.place.prism.z_min > RAISED_M for a in group]
        weights = _evened(np.array(raised, dtype=bool))
        if group:
            chosen = rng.choice(len(group), len(group), replace=False, p=weights)
            orders.append([group[i] for i in chosen])
    return orders


def _evened(group: npt.NDArray[np.bool_]) -> FloatArray:
    """Weights that give a group and the rest the same share, and add up to one."""
    weights: FloatArray = np.where(group, 1 / max(group.sum(), 1), 1 / max((~group).sum(), 1))
    weights /= max(float(weights.sum()), 1e-9)
    return weights


def _hard_things(
    annotation: Annotation, words: Usage, depth: int, rng: np.random.Generator
) -> Annotation:
    """Other candidates for the OBJECTs and PLACEs of every third level."""
    nodes = list(breadth_first(annotation.sdcs))
    groundings = list(annotation.groundings)
    correct: list[bool | None] = [None] * len(nodes)
    for n, level in enumerate(_levels(annotation.sdcs)):
        if level % DEPTHS != depth or nodes[n].type not in ("OBJECT", "PLACE"):
            continue
        others = other_things(Clause.of(annotation, n), words, rng)
        if others and _is_right(annotation, n):
            groundings[n], correct[n] = others, False
        else:
            groundings[n] = ()
    return replace(
        annotation,
        id=f"{annotation.id}/hard-objects-{depth}",
        groundings=tuple(groundings),
        correct=tuple(correct),
        source="hard",
    )


def _is_right(annotation: Annotation, node: int) -> bool:
    return annotation.correct[node] is True and bool(annotation.groundings[node])


def _after(groundings: Groundings, outcome: Outcome) -> Groundings:
    """Return the same things, with the trajectories that an action gives them."""
    by_id = {o.id: o for o in (outcome.agent, *outcome.objects)}
    return tuple(
        by_id.get(g.id, replace(g, trajectory=at_rest(g.trajectory)))
        if isinstance(g, PhysicalObject)
        else g
        for g in groundings
    )


def _levels(sdcs: Sequence[SDC]) -> list[int]:
    """Return the depth of each clause, in breadth-first order."""
    levels = [0] * sum(1 for _ in breadth_first(sdcs))
    for node, children in enumerate(child_indices(sdcs)):
        for child in (c for group in children.values() for c in group):
            levels[child] = levels[node] + 1
    return levels


def _roots(sdcs: Sequence[SDC]) -> list[int]:
    """EVENTs and PATHs that stand below no other."""
    nodes = list(breadth_first(sdcs))
    acts = [n for n, sdc in enumerate(nodes) if sdc.type in ("EVENT", "PATH")]
    children = child_indices(sdcs)
    covered = {n for act in acts for n in below(children, [act])[1:]}
    return [n for n in acts if n not in covered]
