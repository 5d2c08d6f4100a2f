"""The first pass: candidate groundings of OBJECTs and PLACEs with their scores (section 3.4).

From the leaves of a clause upwards, each clause has a beam of candidates: groundings, each with
the best groundings of the clauses below it, and the sum of the log-probabilities of their factors.
Candidates with equal scores keep the order in which they were made: objects as the context lists
them, then groups, then places.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from g3.examples import factor_words
from g3.features.batch import FactorBatch
from g3.features.bodies import IntArray
from g3.groundings import FloatArray, Grounding, PhysicalObject
from g3.inference.candidates import grounded, spots_about, spots_of_robot
from g3.inference.costs import Cost
from g3.inference.scene import Scene
from g3.inference.sides import side_scores
from g3.inference.state import State
from g3.language.groups import group as group_of
from g3.language.words import field_words
from g3.sdc import SDC, Field, breadth_first, child_indices

Group = tuple[Grounding, ...]

WIDTH = 20
"""The paper's beam width."""
LANDMARKS = 6
FAR_BEHIND = 6.0
"""Landmarks, themes and goals with a log-probability so much less than the best one's are left."""
COMMON = 2
"""Places that are not about a landmark are tried with so many of them."""
PRONOUNS = frozenset({"it", "them", "they", "itself"})
BETWEEN = frozenset({"between", "inbetween", "among"})
OTHERS = frozenset({"other", "another"})
MISCOUNTED = float(np.log(0.1))
ONE_FOR_MANY = float(np.log(0.4))
"""A plural often names one thing that holds many: "the tires"."""
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
class Tree:
    """A command's clauses with what is looked up again and again.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    """

    sdcs: tuple[SDC, ...]

    @cached_property
    def nodes(self) -> list[SDC]:
        """All clauses, breadth first."""
        return list(breadth_first(self.sdcs))

    @cached_property
    def children(self) -> list[dict[Field, tuple[int, ...]]]:
        """The clauses in the fields of each."""
        return child_indices(self.sdcs)

    @cached_property
    def words(self) -> list[dict]:  # type: ignore[type-arg]
        """Words of each clause's factor."""
        return [factor_words(sdc) for sdc in self.nodes]

    @cached_property
    def parts(self) -> frozenset[int]:
        """OBJECTs of which another clause says more without a landmark: "the pallet" of tires."""
        return frozenset(
            child
            for node, sdc in enumerate(self.nodes)
            if sdc.type == "OBJECT" and (is_complement(sdc) or not sdc.landmark1)
            for child in (*self.children[node].get("f", ()), *self.children[node].get("l", ()))
        )

    def all_below(self, node: int) -> list[int]:
        """A clause and all clauses in it."""
        found = [node]
        for n in found:
            found.extend(c for group in self.children[n].values() for c in group)
        return found

    def below(self, node: int, fields: Sequence[Field], *types: str) -> list[int]:
        """Clauses of some types in some fields of another, in the order of the fields."""
        return [
            child
            for name in fields
            for child in self.children[node].get(name, ())
            if self.nodes[child].type in types and not self.nodes[child].is_implicit
        ]


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
    if sdc.type == "PLACE":
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
        own = [Candidate(group, 0.0, {}) for group in about.scene.groups]
    if node in about.answers:
        own = [c for c in own if _ids(c.group) == (about.answers[node],)] or own
    pairs = [(f, lm) for f in own for lm in landmarks]
    if is_complement(sdc):
        pairs = _same(own, landmarks) or pairs
    return _scored(tree, node, about, pairs)


def is_complement(sdc: SDC) -> bool:
    """Whether an OBJECT's landmark names the same thing: "the pallet of tires"."""
    return sdc.type == "OBJECT" and field_words(sdc.relation) == ("of",)


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


def names_other(sdc: SDC) -> bool:
    """Whether a leaf names something else than what was meant before: "the other truck"."""
    return any(w.text.lower().strip(".,;:!") in OTHERS for w in sdc.words)


def number_scores(sdc: SDC, sizes: IntArray) -> FloatArray:
    """What it costs groups of some sizes (n,) that a noun speaks of another number; shape (n,)."""
    said = group_of(sdc)
    if said.count is not None and said.count > 1:
        return np.where(sizes == said.count, 0.0, MISCOUNTED)
    if said.number == "singular":
        return np.where(sizes == 1, 0.0, MISCOUNTED)
    return np.where(sizes > 1, 0.0, ONE_FOR_MANY)


def other_side_scores(sdc: SDC, batch: FactorBatch) -> FloatArray:
    """What it costs rows that an OBJECT's words single out another thing, shape (n,)."""
    if sdc.landmark1 and not is_complement(sdc):
        batch = replace(batch, words=[{**words, "figure": ()} for words in batch.words])
    return side_scores(batch)


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
    common = [grounded(p, about.state) for p in about.state.context.places]
    common += spots_of_robot(about.state)
    pairs: list[tuple[Candidate, Candidate | None]] = []
    for number, landmark in enumerate(landmarks):
        spots = [] if landmark is None else spots_about(landmark.group, about.state)
        more = common if number < COMMON else []
        pairs += [(Candidate((s,), 0.0, {}), landmark) for s in (*spots, *more)]
    return _scored(tree, node, about, pairs)


def _scored(
    tree: Tree,
    node: int,
    about: Surroundings,
    pairs: Sequence[tuple[Candidate, Candidate | None]],
) -> list[Candidate]:
    """The best candidates of a clause from figures and landmarks, one for each grounding."""
    marks = [lm.group for _, lm in pairs if lm is not None]
    bodies, index = about.scene.indices([*(f.group for f, _ in pairs), *marks])
    n = len(pairs)
    landmark = np.full(n, -1, dtype=np.intp)
    landmark[[i for i, (_, lm) in enumerate(pairs) if lm is not None]] = index[n:]
    batch = about.scene.batch(
        tree.nodes[node].type,
        [tree.words[node]],
        np.zeros(n, dtype=np.intp),
        bodies,
        figure=index[:n],
        landmark=landmark,
    )
    own = about.cost.log_probability(batch)
    if tree.nodes[node].type == "OBJECT" and not tree.nodes[node].figure:
        sizes = np.array([len(figure.group) for figure, _ in pairs])
        own = own + number_scores(tree.nodes[node], sizes)
    if tree.nodes[node].type == "OBJECT" and node not in tree.parts:
        own = own + other_side_scores(tree.nodes[node], batch)
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
