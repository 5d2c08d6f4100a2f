"""The first pass: candidate groundings of OBJECTs and PLACEs with their scores (section 3.4).

From the leaves of a clause upwards, each clause has a beam of candidates: groundings, each with
the best groundings of the clauses below it, and the sum of the log-probabilities of their factors.
Candidates with equal scores keep the order in which they were made: objects as the context lists
them, then groups, then places.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import log

import numpy as np

from g3.actions.grounding_candidates import (
    ANY_SPOTS,
    SpotsAsked,
    are_free,
    beneath,
    ground,
    grounded,
    spots_about,
    spots_of_load,
    spots_of_robot,
    spots_toward,
    square,
    standing,
)
from g3.actions.robot_state import State
from g3.features.factor_batch import FactorBatch, Role
from g3.features.sets.ranks import is_member
from g3.geometry.footprints import centre
from g3.geometry.relations import LEVEL_M
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.potentials.cases import CandidateCase, FactorCase, ReferentCase, SpotCase
from g3.inference.potentials.potential_registry import added, allowed
from g3.inference.problem.asked_spots import spots_asked
from g3.inference.problem.clause_roles import landmark_nodes
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost, Scorer
from g3.inference.problem.grounding_problem import (
    LANDMARKS,
    Candidate,
    GroundingProblem,
    Group,
    group_key,
    things_of,
)
from g3.inference.problem.later_sides import says_later, seen_from
from g3.inference.problem.packed_scene import Scene
from g3.inference.problem.phrases import (
    factor_type,
    is_complement,
    is_floor,
    is_measure,
    is_pronoun,
    is_stead,
    is_there,
    names_origin,
)
from g3.language.discourse.groups import is_partitive
from g3.language.discourse.negation import negated
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDCType

FAR_BEHIND = 6.0
"""Gap to the best log-probability at which landmarks, themes and goals are dropped."""
COMMON = 2
"""Number of landmarks that are tried with places that are about no thing."""
SEEN_BEFORE = log(0.3)
"""Log-prior that a bare side word refers to the pose before the turn."""
JOINT_LANDMARKS = 3
"""Number of landmarks tried for each PLACE where several PLACEs name one place."""


def likely(beam: Sequence[Candidate], count: int) -> list[Candidate]:
    """Return the best candidates of a beam, without those far behind the best."""
    return [c for c in beam[:count] if c.score >= beam[0].score - FAR_BEHIND]


def leaf_scores(tree: Tree, scene: Scene, cost: Cost) -> dict[int, FloatArray]:
    """Return the log-probabilities of a scene's groups for OBJECTs without clauses below, by node.

    Only of a learned cost: one that is random depends on what else is in a batch.
    """
    if not isinstance(cost, Scorer):
        return {}
    nodes = [n for n in range(len(tree.nodes)) if _is_leaf(tree, n)]
    if not nodes:
        return {}
    groups = np.arange(len(scene.groups))
    batch = scene.batch(
        "OBJECT",
        [tree.words[n] for n in nodes],
        np.repeat(np.arange(len(nodes)), len(groups)),
        figure=np.tile(groups, len(nodes)),
    )
    scores = cost.log_probability(batch).reshape(len(nodes), -1)
    return dict(zip(nodes, scores, strict=True))


def _is_leaf(tree: Tree, node: int) -> bool:
    sdc = tree.nodes[node]
    if sdc.is_implicit or factor_type(sdc) != "OBJECT" or is_pronoun(sdc):
        return False
    return not tree.below(node, ("f", "l", "l2"), "OBJECT", "PLACE", "PATH")


def ground_thing(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate]:
    """Return the beam of an OBJECT or a PLACE, the best first."""
    later = seen_from(tree, node, problem)
    beam = _ground_thing(tree, node, later)
    if later is problem or says_later(tree, node):
        return beam
    # After a turn a side may be meant as it was before it.
    before = _ground_thing(tree, node, replace(problem, later=None))
    before = [replace(c, score=c.score + SEEN_BEFORE) for c in before]
    best: dict[tuple[object, ...], Candidate] = {}
    for c in sorted((*beam, *before), key=lambda c: -c.score):
        best.setdefault(group_key(c.group), c)
    return list(best.values())[: problem.width]


def _ground_thing(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate]:
    sdc = tree.nodes[node]
    if is_there(sdc) and problem.goals:
        return _there(tree, node, problem)
    if factor_type(sdc) == "PLACE":
        return ground_place(tree, node, problem)
    if is_pronoun(sdc):
        return _antecedents(tree, node, problem)
    if names_origin(sdc):
        return _origin(tree, node, problem)
    landmarks = landmarks_of(tree, node, problem)
    figures = tree.below(node, ("f",), "OBJECT", "PLACE")
    if figures:
        own = ground_thing(tree, figures[0], problem)
        for other in figures[1:]:
            own = _both(own, ground_thing(tree, other, problem), problem.width)
    else:
        groups = problem.scene.groups
        scores = added(CandidateCase(tree, node, problem, groups, "figure", node))
        own = [Candidate(g, float(x), {}) for g, x in zip(groups, scores, strict=True)]
    if node in problem.answers:
        meant = problem.answers[node]
        own = [c for c in own if set(group_key(c.group)) <= set(meant)] or [
            Candidate((problem.state.thing(name),), 0.0, {}) for name in meant
        ]
    pairs = [(f, lm) for f in own for lm in landmarks]
    if is_partitive(sdc):
        pairs = [(f, lm) for f, lm in pairs if lm and _is_part(f.group, lm.group)] or pairs
    elif is_complement(sdc):
        pairs = _same(own, landmarks) or pairs
    return _scored(tree, node, problem, pairs)


def ground_others(
    tree: Tree, known: Mapping[int, object], problem: GroundingProblem
) -> dict[int, tuple[Group, float]]:
    """Return groundings of OBJECTs that no plan depends on: "until you face the truck"."""
    found: dict[int, tuple[Group, float]] = {}
    for node, sdc in enumerate(tree.nodes):
        if sdc.type != "OBJECT" or sdc.is_implicit or is_measure(sdc) or node in {*known, *found}:
            continue
        if beam := ground_thing(tree, node, problem):
            found |= {n: g for n, g in beam[0].nodes.items() if n not in known}
    return found


def _same(
    own: Sequence[Candidate], landmarks: Sequence[Candidate | None]
) -> list[tuple[Candidate, Candidate | None]]:
    """Return pairs of candidates that are one thing."""
    marks = {group_key(lm.group): lm for lm in landmarks if lm is not None}
    return [(f, marks[group_key(f.group)]) for f in own if group_key(f.group) in marks]


def _is_part(group: Group, whole: Group) -> bool:
    """Check that all things of a group are of another one."""
    return set(group_key(group)) <= set(group_key(whole))


def _antecedents(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate]:
    """Return candidates of a pronoun: things that were mentioned, or any."""
    spoken = [group for group, _ in problem.antecedents.get(node, ())]
    groups = {group_key(g): g for g in spoken or reversed(problem.referents)}
    groups |= {group_key(g): g for g in problem.scene.groups if group_key(g) not in groups}
    found = []
    scores = added(ReferentCase(tree, node, problem, tuple(groups.values())))
    for group, score in zip(groups.values(), map(float, scores), strict=True):
        found.append(Candidate(group, score, {node: (group, score)}))
    return sorted(found, key=lambda c: -c.score)[: problem.width]


def _origin(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate]:
    """Return the place of the moved load when the command was given, or the robot."""
    words = {word.text.lower() for word in tree.nodes[node].words}
    if problem.load is None or words & WORDS["you"]:
        at, yaw = problem.state.pose[:2], problem.state.pose[2]
    else:
        thing = problem.state.thing(problem.load)
        at, yaw = centre(thing.prism), float(thing.trajectory.yaw[0])
    group = (square(at, yaw, ground(problem.state)),)
    return [Candidate(group, 0.0, {node: (group, 0.0)})]


def _both(first: list[Candidate], second: list[Candidate], width: int) -> list[Candidate]:
    """Return candidates of two clauses that name one thing, or two things together."""
    pairs = product(first[:LANDMARKS], second[:LANDMARKS])
    joined = [
        Candidate(
            a.group if group_key(a.group) == group_key(b.group) else _union(a.group, b.group),
            a.score + b.score,
            {**a.nodes, **b.nodes},
        )
        for a, b in pairs
    ]
    return sorted(joined, key=lambda c: -c.score)[:width]


def _union(a: Group, b: Group) -> Group:
    seen = {i: g for group in (a, b) for i, g in zip(group_key(group), group, strict=True)}
    return tuple(seen.values())


def landmarks_of(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate | None]:
    """Return candidates of all landmarks of a clause together; None where it has none."""
    sdc = tree.nodes[node]
    count = problem.width if is_complement(sdc) else problem.landmarks
    beam: list[Candidate] = []
    for child in landmark_nodes(tree, node):
        found = ground_argument(tree, child, problem, role="landmark", within=node)
        beam = _both(beam, found, problem.landmarks) if beam else likely(found, count)
    return list(beam) or [None]


def ground_argument(
    tree: Tree, node: int, problem: GroundingProblem, *, role: Role, within: int
) -> list[Candidate]:
    """Return the beam of a clause in another one's role: "the pallet" is on the forks."""
    return as_argument(
        ground_thing(tree, node, problem), tree, node, problem, role=role, within=within
    )


def as_argument(
    beam: list[Candidate],
    tree: Tree,
    node: int,
    problem: GroundingProblem,
    *,
    role: Role,
    within: int,
) -> list[Candidate]:
    """Adapt a clause's beam to the role that it has in another clause."""
    groups = [c.group for c in beam]
    scores = added(CandidateCase(tree, node, problem, groups, role, within))
    if not scores.any():
        return beam
    found = [replace(c, score=c.score + float(x)) for c, x in zip(beam, scores, strict=True)]
    return sorted(found, key=lambda c: -c.score)


def ground_place(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate]:
    """Return the beam of a PLACE, or of the place that a PATH or an OBJECT names."""
    problem = seen_from(tree, node, problem)
    landmarks = landmarks_of(tree, node, problem)
    if is_stead(tree.nodes[node]):
        return _stead(node, problem)
    landmarks = [_now(landmark, problem) for landmark in landmarks]
    if WORDS["nearer"].intersection(field_words(tree.nodes[node].relation)):
        nearer = [c for mark in landmarks if mark for c in _nearer(node, mark, problem)]
        if nearer:
            return sorted(nearer, key=lambda c: -c.score)[: problem.width]
    asked = spots_asked(tree, node)
    pairs: list[tuple[Candidate, Candidate | None]] = []
    for number, landmark in enumerate(landmarks):
        spots = [] if landmark is None else spots_about(landmark.group, problem.state, asked)
        if number < COMMON and not _is_thing(landmark, problem.state):
            spots = [*spots, *_common_spots(problem, asked)]
        pairs += [(Candidate((s,), 0.0, {}), landmark) for s in _room(problem, spots)]
    return _scored(tree, node, problem, pairs)


def _now(landmark: Candidate | None, problem: GroundingProblem) -> Candidate | None:
    """Return a landmark where it is when the clause begins: an earlier one may have moved it."""
    state = problem.later
    if landmark is None or state is None:
        return landmark
    group = tuple(state.thing(g.id) if isinstance(g, PhysicalObject) else g for g in landmark.group)
    return replace(landmark, group=group)


def _stead(node: int, problem: GroundingProblem) -> list[Candidate]:
    """Return the places where what was handled last was at first: "in its stead"."""
    last = next((g for g in reversed(problem.referents) if _ids(g) - {problem.load}), ())
    first = [
        square(centre(thing.prism), float(thing.trajectory.yaw[0]), thing.prism.z_min)
        for thing in map(problem.state.thing, sorted(_ids(last)))
    ]
    spots = [spot for place in first for spot in _free_spots((place,), problem)]
    return [Candidate((spot,), 0.0, {node: ((spot,), 0.0)}) for spot in spots]


def _ids(group: Group) -> set[str]:
    return {thing.id for thing in things_of(group)}


def _is_thing(landmark: Candidate | None, state: State) -> bool:
    """Check that a landmark has a thing other than the robot."""
    return landmark is not None and any(
        isinstance(g, PhysicalObject) and g.id != state.context.agent_id for g in landmark.group
    )


def _nearer(node: int, landmark: Candidate, problem: GroundingProblem) -> list[Candidate]:
    """Return places on the way to a landmark, one step before two: "closer to the trailer"."""
    spots = _room(problem, spots_toward(landmark.group, problem.state, problem.load))
    return [
        Candidate((spot,), landmark.score, {**landmark.nodes, node: ((spot,), 0.0)})
        for spot in spots
    ]


def _there(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate]:
    """Return candidates of a PLACE at the ends of earlier clauses."""
    found = reached(tree, node, problem)
    return [Candidate(c.group, c.score, {node: (c.group, c.score)}) for c in found]


def reached(tree: Tree, node: int, problem: GroundingProblem) -> list[Candidate]:
    """Return places at the ends of earlier clauses, on the thing there rather than beside it.

    Beside it where the clause says "on the ground".
    """
    places = [tree.nodes[n] for n in tree.below(node, ("l", "l2"), "PLACE")]
    down = any(is_floor(mark) for place in places for mark in place.landmark1)
    groups = tuple(dict.fromkeys(reversed(problem.goals)))
    scores = added(ReferentCase(tree, node, problem, groups))
    found = []
    for group, score in zip(groups, map(float, scores), strict=True):
        spots = _free_spots(group, problem)
        top = [s for s in spots if s.prism.z_min > ground(problem.state) + LEVEL_M]
        wanted = [s for s in spots if s not in top] if down else top or spots
        found += [Candidate((s,), score, {}) for s in wanted]
    return found[: problem.width]


def _free_spots(group: Group, problem: GroundingProblem) -> list[Place]:
    """Return places at the end of a clause; beside what was put there, where that has no room."""
    state, load = problem.later or problem.state, problem.load
    spots = spots_about(group, state)
    if not spots or load is None or are_free(spots, state, load).any():
        return spots
    taken = np.flatnonzero(standing(spots, state).any(axis=0))
    there = tuple(state.context.objects[i] for i in taken)
    below = tuple(deck for spot in spots if (deck := beneath(spot, state, load)) is not None)
    return [s for thing in dict.fromkeys(below or there) for s in spots_about((thing,), state)]


def _room(problem: GroundingProblem, spots: list[Place]) -> list[Place]:
    """Return the spots that have room for the load that the clause moves; all if none has."""
    if problem.load is None:
        return spots
    if problem.raised is not None:
        floor = ground(problem.state) + LEVEL_M
        spots = [s for s in spots if (s.prism.z_min > floor) == problem.raised] or spots
    free = allowed(SpotCase(problem, spots))
    return [spot for spot, is_free in zip(spots, free, strict=True) if is_free] or spots


def _common_spots(problem: GroundingProblem, asked: SpotsAsked = ANY_SPOTS) -> list[Place]:
    """Return places that are not about a landmark."""
    state = problem.state
    moved = spots_of_load(problem.load, state, asked.apart) if problem.load else []
    about = spots_of_robot(state, asked.apart)
    return [*(grounded(p, state) for p in state.context.places), *about, *moved]


def ground_places(tree: Tree, nodes: Sequence[int], problem: GroundingProblem) -> list[Candidate]:
    """Return the beam of PLACEs that name one place together: "on the ground, behind you"."""
    stead = [node for node in nodes if is_stead(tree.nodes[node])]
    if len(nodes) == 1 or stead:
        return ground_thing(tree, (stead or nodes)[0], problem)
    problem = seen_from(tree, nodes[0], problem)
    marks = {n: landmarks_of(tree, n, problem)[:JOINT_LANDMARKS] for n in nodes}
    groups = {
        group_key(lm.group): lm.group for lms in marks.values() for lm in lms if lm is not None
    }
    asked = [spots_asked(tree, node) for node in nodes]
    wanted = next((own for own in asked if own != ANY_SPOTS), ANY_SPOTS)
    spots = [s for group in groups.values() for s in spots_about(group, problem.state, wanted)]
    room = _room(problem, [*spots, *_common_spots(problem, wanted)])
    figures = [Candidate((s,), 0.0, {}) for s in room]
    everywhere = replace(problem, width=len(figures))
    joined: dict[int, Candidate] = {}
    for node in nodes:
        pairs = [(f, lm) for f in figures for lm in marks[node]]
        for c in _scored(tree, node, everywhere, pairs):
            other = joined.get(id(c.group[0]), Candidate(c.group, 0.0, {}))
            both = Candidate(c.group, c.score + other.score, {**other.nodes, **c.nodes})
            joined[id(c.group[0])] = both
    return sorted(joined.values(), key=lambda c: -c.score)[: problem.width]


def _evenly(scores: FloatArray, batch: FactorBatch) -> FloatArray:
    """Give all things inside a landmark the best one's score: "the last one in the row"."""
    inside = np.flatnonzero(is_member(batch)) if (batch.landmark >= 0).any() else ()
    if not len(inside):
        return scores
    best = np.full(len(batch.bodies.count), -np.inf)
    np.maximum.at(best, batch.landmark[inside], scores[inside])
    even: FloatArray = scores.copy()
    even[inside] = best[batch.landmark[inside]]
    return even


def _scored(
    tree: Tree,
    node: int,
    problem: GroundingProblem,
    pairs: Sequence[tuple[Candidate, Candidate | None]],
) -> list[Candidate]:
    """Return the best candidates from figures and landmarks, one for each grounding."""
    sdc = tree.nodes[node]
    kind: SDCType = "PLACE" if sdc.type == "PATH" else factor_type(sdc)
    marks = [lm.group for _, lm in pairs if lm is not None]
    bodies, index = problem.scene.indices([*(f.group for f, _ in pairs), *marks])
    n = len(pairs)
    landmark = np.full(n, -1, dtype=np.intp)
    landmark[[i for i, (_, lm) in enumerate(pairs) if lm is not None]] = index[n:]
    batch = problem.scene.batch(
        kind,
        [tree.words[node]],
        np.zeros(n, dtype=np.intp),
        bodies,
        figure=index[:n],
        landmark=landmark,
    )
    known = problem.leaves.get(node)
    if known is None:  # of "not on the truck" the correspondence is false (section 3.2)
        own = problem.cost.log_probability(batch, true=not negated(sdc))
    else:
        own = known[index[:n]]
    own = _evenly(own, batch)
    sizes = [len(figure.group) for figure, _ in pairs]
    own = own + added(FactorCase(tree, node, batch, problem, sizes))
    below = np.array([f.score + (lm.score if lm else 0.0) for f, lm in pairs])
    total = own + below
    best: dict[int, Candidate] = {}
    for i in np.argsort(-total, kind="stable"):
        figure, mark = pairs[i]
        if int(index[i]) in best:
            continue
        nodes = {
            **figure.nodes,
            **(mark.nodes if mark else {}),
            node: (figure.group, float(own[i])),
        }
        best[int(index[i])] = Candidate(figure.group, float(total[i]), nodes)
        if len(best) == problem.width:
            break
    return list(best.values())
