"""The second pass: action sequences for EVENTs and PATHs (section 3.4).

A beam of hypotheses goes through the top-level clauses: for each clause every action that is
possible in a hypothesis' state is scored with every candidate of the clause's theme and goal, and
the state that the action leads to is where the next clause begins. Hypotheses with equal
scores keep the order in which they were found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from g3.actions import centre
from g3.features.batch import FactorBatch
from g3.features.bodies import IntArray
from g3.groundings import FloatArray, Grounding, Path, PhysicalObject, Place, Trajectory
from g3.inference.actions import Action, possible_actions, result
from g3.inference.arguments import Arguments, Rows, arguments, combine, focus_of
from g3.inference.candidates import beneath
from g3.inference.changes import beside_scores, change_scores
from g3.inference.clauses import verb_scores
from g3.inference.costs import Cost, Scorer
from g3.inference.explanation import MOST, reasons_against
from g3.inference.motions import Motions
from g3.inference.scene import Group
from g3.inference.scoring import Reason
from g3.inference.stage import PathFactor, Stage, Trial, event_batch, path_batch
from g3.inference.state import State
from g3.inference.things import (
    Candidate,
    Surroundings,
    Tree,
    ground_thing,
    is_pronoun,
    names_other,
)
from g3.language.anaphora import anaphors
from g3.language.negation import negated

Reasons = tuple[Action, tuple[Reason, ...]]

SPOKEN_OF = float(np.log(0.01))
"""What it costs that "the other truck" is one that was meant before."""
OTHER_PLACE_M = 2.5
"""Places further apart than this are others."""
WIDTH = 5
"""How many hypotheses go on from one top-level clause to the next."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A plan for the clauses so far.

    Parameters
    ----------
    score
        Sum of the log-probabilities of all factors.
    state
        What the plan leads to.
    actions
        The plan, an action for each clause.
    nodes
        Groundings of the clauses, and their factors' log-probabilities.
    referents
        What was acted on, the most recent last.
    reasons
        Where they are asked for: for each EVENT and PATH the best other action, and what spoke
        against it.
    """

    score: float
    state: State
    actions: tuple[Action, ...] = ()
    nodes: Mapping[int, tuple[Group, float]] = field(default_factory=dict)
    referents: tuple[Group, ...] = ()
    reasons: Mapping[int, Reasons] = field(default_factory=dict)


def extend(
    tree: Tree, root: int, before: Hypothesis, found: Arguments, about: Surroundings
) -> Iterator[Hypothesis]:
    """Hypotheses that go on from one with the next top-level clause, the best first."""
    state, cost = before.state, about.cost
    forbidden = negated(tree.nodes[root])
    actions = [Action("wait")] if forbidden else possible_actions(state, focus_of(state, found))
    rows = combine(state, actions, found)
    batch, stage, marks = event_batch(Trial(tree, root, state, found, actions, rows))
    kind = tree.nodes[root].type
    event = np.zeros(len(batch))
    if kind == "EVENT":
        event = cost.log_probability(batch, true=not forbidden)
    theme_score = np.array([*(c.score if c else 0.0 for c in found.themes), 0.0])
    goal_score = np.array([*(c.score if c else 0.0 for c in found.goals), 0.0])
    total = before.score + event + theme_score[rows.theme] + goal_score[rows.goal]
    total = total + other_scores(tree, root, before, found, rows)
    if not forbidden:
        unusual = verb_scores(tree.nodes[root], [a.kind for a in actions])
        unusual = unusual + change_scores(about.state, actions)
        unusual = unusual + beside_scores(tree, root, state, actions, found.goal_path)
        total = total + unusual[rows.action]
    goal_path = np.zeros(len(batch))
    if found.goal_path >= 0:
        goal_path = PathFactor(tree, found.goal_path, stage, cost).scores(batch.figure, batch.goal)
        total = total + goal_path
    chosen: dict[int, tuple[FloatArray, IntArray]] = {}
    for path, bodies in marks.items():
        own, which = PathFactor(tree, path, stage, cost).best(bodies, found.paths[path])
        total = total + own[rows.action]
        chosen[path] = (own, which)
    order = np.argsort(-total, kind="stable")
    ranked = _Ranked(actions, rows.action[order], order)
    factors = _factors(tree, root, found, stage, batch) if about.explain else {}
    taken: set[int] = set()
    for i in order:
        a = int(rows.action[i])
        if a in taken:
            continue
        taken.add(a)
        nodes = dict(before.nodes)
        theme = found.themes[rows.theme[i]] if rows.theme[i] >= 0 else None
        goal = found.goals[rows.goal[i]] if rows.goal[i] >= 0 else None
        for part in (theme, goal):
            nodes |= part.nodes if part else {}
        after = result(state, actions[a], stage.motions, a)
        agent = agent_of(state, stage.motions, a)
        nodes[root] = ((agent,) if kind == "EVENT" else (Path(agent.trajectory),), float(event[i]))
        if found.goal_path >= 0:
            nodes[found.goal_path] = ((Path(agent.trajectory),), float(goal_path[i]))
        for path, (own, which) in chosen.items():
            mark = found.paths[path][int(which[a])]
            nodes |= mark.nodes if mark else {}
            nodes[path] = ((Path(agent.trajectory),), float(own[a]))
        referent = _referent(state, actions[a], theme, stage.motions, a)
        yield Hypothesis(
            float(total[i]),
            after,
            (*before.actions, actions[a]),
            nodes,
            (*before.referents, *referent),
            {**before.reasons, **_reasons(factors, cost, ranked, a)},
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Ranked:
    """Combinations of actions, themes and goals, the best first: actions, and rows of batches."""

    actions: Sequence[Action]
    action: IntArray
    row: IntArray


def _factors(
    tree: Tree, root: int, found: Arguments, stage: Stage, batch: FactorBatch
) -> dict[int, FactorBatch]:
    """The factors of an EVENT and of the PATH that leads to its goal, with the same rows."""
    factors = {root: batch} if tree.nodes[root].type == "EVENT" else {}
    if found.goal_path >= 0:
        path = path_batch(tree, found.goal_path, stage, batch.figure, batch.goal)
        factors[found.goal_path] = path
    return factors


def _reasons(
    factors: Mapping[int, FactorBatch], cost: Cost, ranked: _Ranked, action: int
) -> dict[int, Reasons]:
    """What spoke for an action against the best one that does something else, by clause."""
    if not isinstance(cost, Scorer):
        return {}
    chosen = ranked.actions[action]
    other = np.array([_differs(a, chosen) for a in ranked.actions])[ranked.action]
    if not factors or not other.any():
        return {}
    first, best = (int(np.flatnonzero(x)[0]) for x in (ranked.action == action, other))
    rows = int(ranked.row[first]), int(ranked.row[best])
    rival = ranked.actions[int(ranked.action[best])]
    return {n: (rival, tuple(reasons_against(f, rows, cost)[:MOST])) for n, f in factors.items()}


def _differs(action: Action, other: Action) -> bool:
    """Whether two actions do something else: not the same a little further on.

    Nor the same with another load: the theme's own reasons tell why it isn't that one.
    """
    if action.object_id and other.object_id and action.object_id != other.object_id:
        return False
    if action.place is not None and other.place is not None:
        apart = np.linalg.norm(centre(action.place.prism) - centre(other.place.prism))
        return action.kind != other.kind or bool(apart > OTHER_PLACE_M)
    return (action.kind, action.target, action.amount) != (other.kind, other.target, other.amount)


def other_scores(
    tree: Tree, root: int, before: Hypothesis, found: Arguments, rows: Rows
) -> FloatArray:
    """What "the other truck" costs each row if it is one that was meant before.

    That is anything that an earlier clause is grounded in, and what the theme stands on.
    """
    total = np.zeros(len(rows.action))
    nodes = [n for n in tree.all_below(root) if names_other(tree.nodes[n])]
    if not nodes:
        return total
    spoken = {_id(g) for group, _ in before.nodes.values() for g in group}
    spoken -= {"", before.state.context.agent_id}
    for i, (t, g) in enumerate(zip(rows.theme, rows.goal, strict=True)):
        theme = found.themes[t] if t >= 0 else None
        goal = found.goals[g] if g >= 0 else None
        meant = {**(theme.nodes if theme else {}), **(goal.nodes if goal else {})}
        under = _support(before.state, theme)
        for n in nodes:
            if n in meant and {_id(x) for x in meant[n][0]} & (spoken | under):
                total[i] += SPOKEN_OF
    return total


def _id(grounding: Grounding) -> str:
    return grounding.id if isinstance(grounding, PhysicalObject) else ""


def _support(state: State, theme: Candidate | None) -> set[str]:
    """Id of what a theme stands on."""
    thing = theme.group[0] if theme else None
    if not isinstance(thing, PhysicalObject):
        return set()
    under = beneath(Place(state.thing(thing.id).prism), state, thing.id)
    return {under.id} if under else set()


def _referent(
    state: State, action: Action, theme: Candidate | None, motion: Motions, row: int
) -> tuple[Group, ...]:
    if action.object_id:
        return ((state.thing(action.object_id),),)
    if theme is not None:
        return (theme.group,)
    if action.target and isinstance(action.target[0], PhysicalObject):
        return (action.target,)
    return ()


def agent_of(state: State, motion: Motions, row: int) -> PhysicalObject:
    """The robot with the trajectory of an action."""
    track = Trajectory(motion.t[row], motion.xyz[row], motion.yaw[row])
    return replace(state.context.agent, trajectory=track)


def search(
    tree: Tree, start: State, about: Surroundings, *, width: int = WIDTH
) -> list[Hypothesis]:
    """The best plans for a command, the best first."""
    beam = [Hypothesis(0.0, start)]
    known = {a.index: a.antecedents for a in anaphors(tree.sdcs) if a.kind == "same"}
    for root, sdc in enumerate(tree.sdcs):
        if sdc.type in ("OBJECT", "PLACE"):
            beam = _mentioned(tree, root, beam, about)[:width]
            continue
        pronouns = [n for n in tree.all_below(root) if is_pronoun(tree.nodes[n])]
        grounded: dict[tuple[object, ...], Arguments] = {}
        grown: list[Hypothesis] = []
        for before in beam:
            spoken = before.referents if pronouns else ()
            meant = {
                n: tuple(
                    (before.nodes[x.index][0], x.probability)
                    for x in known.get(n, ())
                    if x.index in before.nodes
                )
                for n in pronouns
            }
            key = (spoken, *meant.values())
            if key not in grounded:
                around = replace(about, referents=spoken, antecedents=meant)
                grounded[key] = arguments(tree, root, around)
            grown += islice(extend(tree, root, before, grounded[key], about), width)
        beam = sorted(grown, key=lambda h: -h.score)[:width]
    return beam


def _mentioned(
    tree: Tree, root: int, beam: Sequence[Hypothesis], about: Surroundings
) -> list[Hypothesis]:
    """Hypotheses after a clause that only names something: "the tires on the truck, lift them"."""
    found = ground_thing(tree, root, about)
    grown = [
        replace(
            before,
            score=before.score + c.score,
            nodes={**before.nodes, **c.nodes},
            referents=(*before.referents, c.group),
        )
        for before in beam
        for c in found
    ]
    return sorted(grown, key=lambda h: -h.score)
