"""The first pass: candidate groundings of OBJECTs and PLACEs with their scores (section 3.4).

From the leaves of a clause upwards, each clause has a beam of candidates: groundings, each with
the best groundings of the clauses below it, and the sum of the log-probabilities of their factors.
Candidates with equal scores keep the order in which they were made: objects as the context lists
them, then groups, then places.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from g3.features.batch import FactorBatch
from g3.groundings import FloatArray, Grounding, PhysicalObject, Place
from g3.inference.candidates import GROUND_M, ground, grounded, spots_about, spots_of_robot
from g3.inference.costs import Cost
from g3.inference.phrases import (
    MISCOUNTED,
    factor_type,
    is_bare,
    is_complement,
    is_there,
    names_other,
    number_scores,
)
from g3.inference.places import carrier, free_places, place_scores
from g3.inference.salience import near_scores
from g3.inference.scene import Scene
from g3.inference.sides import MISPLACED, side_scores
from g3.inference.state import State
from g3.inference.tree import Tree
from g3.language.words import field_words
from g3.sdc import SDC

Group = tuple[Grounding, ...]

WIDTH = 20
"""The paper's beam width."""
LANDMARKS = 6
FAR_BEHIND = 6.0
"""Landmarks, themes and goals with a log-probability so much less than the best one's are left."""
COMMON = 2
"""Places that are not about a landmark are tried with so many of them."""
JOINT_LANDMARKS = 3
"""So many landmarks of each PLACE are tried where several name one place."""
PRONOUNS = frozenset({"it", "them", "they", "itself"})
BETWEEN = frozenset({"between", "inbetween", "among"})
SPOKEN_OF = float(np.log(0.01))
"""What it costs that "the other truck" is one that was meant before."""
UNSPOKEN = 0.01
"""Probability that a pronoun stands for a thing that was not spoken of."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A grounding of a clause.

    Parameters
    ----------
    group
        The grounding.
    score
        Sum of the log-probabilities of the clause's factor and of those below it.
    nodes
        The groundings of the clause and of all below it, and their factors' log-probabilities.
    """

    group: Group
    score: float
    nodes: Mapping[int, tuple[Group, float]]


@dataclass(frozen=True)
class Surroundings:
    """What the first pass grounds clauses in.

    Parameters
    ----------
    state
        The state that the command was given in.
    scene
        Its things, packed.
    cost
        Scores of factors.
    referents
        What was acted on or spoken of before, the most recent last.
    antecedents
        What pronouns may stand for by :mod:`g3.language.anaphora`, with probabilities: the
        groundings of OBJECTs of earlier clauses, by the pronoun's clause.
    goals
        What earlier clauses lead to, the last one last: "there" is one of them.
    spoken
        Ids of what earlier clauses mean.
    load
        Id of what the clause moves: it goes where there is room for it, and is no landmark of that.
    width
        Width of the beams.
    landmarks
        Of a clause's beam, how many candidates are tried as landmarks.
    answers
        Ids of objects that clauses are known to mean.
    explain
        Whether reasons are asked for.
    """

    state: State
    scene: Scene
    cost: Cost
    referents: tuple[Group, ...] = ()
    antecedents: Mapping[int, tuple[tuple[Group, float], ...]] = field(default_factory=dict)
    goals: tuple[Group, ...] = ()
    spoken: frozenset[str] = frozenset()
    load: str | None = None
    width: int = WIDTH
    landmarks: int = LANDMARKS
    answers: Mapping[int, str] = field(default_factory=dict)
    explain: bool = False


def likely(beam: Sequence[Candidate], count: int) -> list[Candidate]:
    """The best candidates of a beam, without those that are far behind the best."""
    return [c for c in beam[:count] if c.score >= beam[0].score - FAR_BEHIND]


def ground_thing(tree: Tree, node: int, about: Surroundings) -> list[Candidate]:
    """The beam of an OBJECT or a PLACE, the best first."""
    sdc = tree.nodes[node]
    if is_there(sdc) and about.goals:
        return _there(node, about)
    if factor_type(sdc) == "PLACE":
        return _place(tree, node, about)
    if is_pronoun(sdc):
        return _antecedents(node, about)
    landmarks = _landmarks(tree, node, about)
    figures = tree.below(node, ("f",), "OBJECT", "PLACE")
    if figures:
        own = ground_thing(tree, figures[0], about)
        for other in figures[1:]:
            own = _both(own, ground_thing(tree, other, about), about.width)
    else:
        score = _barred(sdc, about)
        own = [Candidate(g, score(g), {}) for g in about.scene.groups]
    if node in about.answers:
        own = [c for c in own if _ids(c.group) == (about.answers[node],)] or own
    pairs = [(f, lm) for f in own for lm in landmarks]
    if is_complement(sdc):
        pairs = _same(own, landmarks) or pairs
    return _scored(tree, node, about, pairs)


def _barred(sdc: SDC, about: Surroundings) -> Callable[[Group], float]:
    """What it costs a leaf to be grounded in what it surely isn't.

    What is carried is no landmark of where it goes. "The other truck" is none that was meant
    before, nor what the load stands on.
    """
    load = {about.load} if about.load else set()
    meant = about.spoken | _carrier(about) if names_other(sdc) else set()

    def score(group: Group) -> float:
        ids = {g.id for g in group if isinstance(g, PhysicalObject)}
        return (MISPLACED if ids & load else 0.0) + (SPOKEN_OF if ids & meant else 0.0)

    return score


def _carrier(about: Surroundings) -> set[str]:
    """Id of what the load stands on."""
    under = carrier(about.state, about.load) if about.load else None
    return {under.id} if under else set()


def _same(
    own: Sequence[Candidate], landmarks: Sequence[Candidate | None]
) -> list[tuple[Candidate, Candidate | None]]:
    """Pairs of candidates that are one thing."""
    marks = {_ids(lm.group): lm for lm in landmarks if lm is not None}
    return [(f, marks[_ids(f.group)]) for f in own if _ids(f.group) in marks]


def is_pronoun(sdc: SDC) -> bool:
    """Whether an OBJECT is a pronoun that stands for something spoken of before."""
    words = [w.text.lower().strip(".,;:!") for w in sdc.words]
    return sdc.type == "OBJECT" and len(words) == 1 and words[0] in PRONOUNS


def unmeant_scores(tree: Tree, node: int, batch: FactorBatch, sizes: Sequence[int]) -> FloatArray:
    """What it costs rows that an OBJECT's words speak of another number or another thing alike.

    Parameters
    ----------
    sizes
        How many things each row's figure is.
    """
    sdc = tree.nodes[node]
    total = np.zeros(len(batch))
    if not sdc.figure:
        total = total + number_scores(sdc, np.array(sizes))
    if node not in tree.parts:
        if sdc.landmark1 and not is_complement(sdc):
            batch = replace(batch, words=[{**words, "figure": ()} for words in batch.words])
        total = total + side_scores(batch)
    return total


def _antecedents(node: int, about: Surroundings) -> list[Candidate]:
    """What a pronoun may stand for: by its antecedents, or if it has none by what came last."""
    likely = about.antecedents.get(node) or [
        (group, 0.9 * 0.1**i) for i, group in enumerate(dict.fromkeys(reversed(about.referents)))
    ]
    groups = {_ids(group): group for group, _ in likely}
    groups |= {_ids(group): group for group in about.scene.groups if _ids(group) not in groups}
    found = []
    for ids, group in groups.items():
        mass = sum(p for other, p in likely if _ids(other) == ids)
        score = float(np.log(max(mass, UNSPOKEN)))
        found.append(Candidate(group, score, {node: (group, score)}))
    return sorted(found, key=lambda c: -c.score)[: about.width]


def _ids(group: Group) -> tuple[object, ...]:
    return tuple(g.id if isinstance(g, PhysicalObject) else id(g) for g in group)


def _both(first: list[Candidate], second: list[Candidate], width: int) -> list[Candidate]:
    """Candidates of two clauses that name one thing, or two things together."""
    pairs = product(first[:LANDMARKS], second[:LANDMARKS])
    joined = [
        Candidate(
            a.group if _ids(a.group) == _ids(b.group) else _union(a.group, b.group),
            a.score + b.score,
            {**a.nodes, **b.nodes},
        )
        for a, b in pairs
    ]
    return sorted(joined, key=lambda c: -c.score)[:width]


def _union(a: Group, b: Group) -> Group:
    seen = {i: g for group in (a, b) for i, g in zip(_ids(group), group, strict=True)}
    return tuple(seen.values())


def _landmarks(tree: Tree, node: int, about: Surroundings) -> list[Candidate | None]:
    """Candidates of all landmarks of a clause together; None where it has none."""
    sdc = tree.nodes[node]
    count = about.width if is_complement(sdc) else about.landmarks
    children = tree.below(node, ("l", "l2"), "OBJECT", "PLACE")
    if not children:
        below = tree.below(node, ("l", "l2"), "PATH")
        children = [c for b in below for c in tree.below(b, ("l", "l2"), "OBJECT", "PLACE")]
    beam: list[Candidate] = []
    for child in children:
        found = ground_thing(tree, child, about)
        if len(children) == 1 and BETWEEN.intersection(field_words(sdc.relation)):
            found = _several(found)
        beam = _both(beam, found, about.landmarks) if beam else likely(found, count)
    return list(beam) or [None]


def _several(beam: Sequence[Candidate]) -> list[Candidate]:
    """A beam in which single things cost: what is between the pallets is between two of them."""
    dear = [replace(c, score=c.score + MISCOUNTED) if len(c.group) == 1 else c for c in beam]
    return sorted(dear, key=lambda c: -c.score)


def _place(tree: Tree, node: int, about: Surroundings) -> list[Candidate]:
    landmarks = _landmarks(tree, node, about)
    common = _common_spots(about.state)
    pairs: list[tuple[Candidate, Candidate | None]] = []
    for number, landmark in enumerate(landmarks):
        spots = [] if landmark is None else spots_about(landmark.group, about.state)
        more = common if number < COMMON else []
        room = _room(about, [*spots, *more])
        pairs += [(Candidate((s,), 0.0, {}), landmark) for s in room]
    return _scored(tree, node, about, pairs)


def _there(node: int, about: Surroundings) -> list[Candidate]:
    """Places at what earlier clauses lead to, the last one first; on it rather than beside it."""
    found = []
    for number, group in enumerate(dict.fromkeys(reversed(about.goals))):
        score = float(np.log(0.9 * 0.1**number))
        spots = spots_about(group, about.state)
        top = [s for s in spots if s.prism.z_min > ground(about.state) + GROUND_M]
        found += [Candidate((s,), score, {node: ((s,), score)}) for s in top or spots]
    return found[: about.width]


def _room(about: Surroundings, places: list[Place]) -> list[Place]:
    """Places where there is room for what the clause moves; all of them if there is none."""
    return places if about.load is None else free_places(places, about.state, about.load) or places


def _common_spots(state: State) -> list[Place]:
    """Places that are not about a landmark."""
    return [grounded(p, state) for p in state.context.places] + spots_of_robot(state)


def ground_places(tree: Tree, nodes: Sequence[int], about: Surroundings) -> list[Candidate]:
    """The beam of PLACEs that name one place together: "on the ground, behind you"."""
    if len(nodes) == 1:
        return ground_thing(tree, nodes[0], about)
    marks = {n: _landmarks(tree, n, about)[:JOINT_LANDMARKS] for n in nodes}
    groups = {_ids(lm.group): lm.group for lms in marks.values() for lm in lms if lm is not None}
    spots = [s for group in groups.values() for s in spots_about(group, about.state)]
    room = _room(about, [*spots, *_common_spots(about.state)])
    figures = [Candidate((s,), 0.0, {}) for s in room]
    everywhere = replace(about, width=len(figures))
    joined: dict[int, Candidate] = {}
    for node in nodes:
        pairs = [(f, lm) for f in figures for lm in marks[node]]
        for c in _scored(tree, node, everywhere, pairs):
            other = joined.get(id(c.group[0]), Candidate(c.group, 0.0, {}))
            both = Candidate(c.group, c.score + other.score, {**other.nodes, **c.nodes})
            joined[id(c.group[0])] = both
    return sorted(joined.values(), key=lambda c: -c.score)[: about.width]


def _scored(
    tree: Tree,
    node: int,
    about: Surroundings,
    pairs: Sequence[tuple[Candidate, Candidate | None]],
) -> list[Candidate]:
    """The best candidates of a clause from figures and landmarks, one for each grounding."""
    sdc = tree.nodes[node]
    kind = factor_type(sdc)
    marks = [lm.group for _, lm in pairs if lm is not None]
    bodies, index = about.scene.indices([*(f.group for f, _ in pairs), *marks])
    n = len(pairs)
    landmark = np.full(n, -1, dtype=np.intp)
    landmark[[i for i, (_, lm) in enumerate(pairs) if lm is not None]] = index[n:]
    batch = about.scene.batch(
        kind,
        [tree.words[node]],
        np.zeros(n, dtype=np.intp),
        bodies,
        figure=index[:n],
        landmark=landmark,
    )
    own = about.cost.log_probability(batch)
    if kind == "PLACE":
        own = own + place_scores(sdc, batch, ground(about.state))
    else:
        sizes = [len(figure.group) for figure, _ in pairs]
        own = own + unmeant_scores(tree, node, batch, sizes)
    if about.load and is_bare(sdc) and node not in tree.parts:
        ids = [o.id for o in about.state.context.objects]
        own = own + near_scores(batch, ids.index(about.load))
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
        if len(best) == about.width:
            break
    return list(best.values())
