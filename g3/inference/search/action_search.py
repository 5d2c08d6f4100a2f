"""The second pass: action sequences for EVENTs and PATHs (section 3.4).

A beam of hypotheses goes through the top-level clauses: for each clause, every action that is
possible in a hypothesis' state is scored with every candidate of the clause's theme and goal. The
next clause begins in the state that the action leads to. Hypotheses with equal scores keep the
order in which the search made them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from math import log

import numpy as np

from g3.actions.action_kinds import Action, agent_of, possible_actions, result
from g3.actions.forklift_actions import WAIT
from g3.actions.grounding_candidates import carrier, deck_row, is_surface
from g3.actions.motions import Motions
from g3.actions.robot_state import State, is_load
from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch
from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray
from g3.geometry.relations import OTHER_PLACE_M
from g3.groundings import FloatArray, Path, PhysicalObject
from g3.inference.potentials.cases import ActionCase, PathCase
from g3.inference.potentials.potential_registry import added, added_by
from g3.inference.problem.clause_roles import names_again
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost, Scorer
from g3.inference.problem.frames import asked, frame, in_order, told_side
from g3.inference.problem.grounding_problem import (
    Arguments,
    Candidate,
    GroundingProblem,
    one_each,
)
from g3.inference.problem.later_sides import is_seen_later
from g3.inference.problem.packed_scene import Group
from g3.inference.problem.phrases import (
    is_on_top,
    is_pronoun,
    is_stead,
    is_there,
    names_other,
    names_same,
)
from g3.inference.problem.scoring import Reason
from g3.inference.reasons.explanation import reasons_against, told_besides, weightiest
from g3.inference.search.arguments import arguments, combine, focus_of
from g3.inference.search.exchange import after_actions, exchange
from g3.inference.search.requests import Request, after, next_request, ruled_out
from g3.inference.search.stage import PathFactor, Stage, Trial, event_batch, path_batch
from g3.inference.search.thing_search import ground_thing, leaf_scores
from g3.sdc.clauses import SDC_TYPES
from g3.short_repr import short_repr

Reasons = tuple[Action, tuple[Reason, ...]]
Choices = tuple[tuple[Group, float], ...]

UNTAUGHT = log(0.5)
"""Score of an EVENT whose kind of action is only done on request: no log teaches it."""
WIDTH = 5
"""Number of hypotheses that go on from one top-level clause to the next."""


@short_repr
@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A plan for the clauses so far.

    Parameters
    ----------
    score
        Sum of the log-probabilities of all factors.
    state
        The state after the plan.
    actions
        The plan.
    nodes
        Groundings of the clauses, and their factors' log-probabilities.
    referents
        Things that were acted on, the most recent last.
    goals
        Ends of the clauses, the last one last.
    reasons
        On request, for each top-level clause the best other action, and the evidence against it.
    choices
        Groundings that clauses could have, by node, the best first: each with the score of the best
        action after the plan's earlier clauses that was possible then.
    problems
        Where reasons are requested, the problems in which clauses were grounded.
    undone
        Ids of loads that were meant, and for which there is no room or no way.
    clauses
        The top-level clause of each action.
    """

    score: float
    state: State
    actions: tuple[Action, ...] = ()
    nodes: Mapping[int, tuple[Group, float]] = field(default_factory=dict)
    referents: tuple[Group, ...] = ()
    goals: tuple[Group, ...] = ()
    reasons: Mapping[int, Reasons] = field(default_factory=dict)
    choices: Mapping[int, Choices] = field(default_factory=dict)
    problems: Mapping[int, GroundingProblem] = field(default_factory=dict)
    undone: tuple[str, ...] = ()
    clauses: tuple[int, ...] = ()


def _problems(
    found: Arguments, theme: Candidate | None, goal: Candidate | None
) -> dict[int, GroundingProblem]:
    """Return the problems in which the clauses of a theme and of a goal were grounded."""
    pairs = ((theme, found.problem), (goal, found.toward))
    return {n: problem for part, problem in pairs if part and problem for n in part.nodes}


def extend(
    tree: Tree, root: int, before: Hypothesis, found: Arguments, problem: GroundingProblem
) -> Iterator[Hypothesis]:
    """Yield the hypotheses that extend one by the next top-level clause, the best first."""
    state, cost = before.state, problem.cost
    forbidden = frame(tree, root).negated
    actions = [Action(WAIT)] if forbidden else _allowed(tree, root, state, found, problem)
    if not actions:
        return
    rows = combine(state, actions, found)
    scene = problem.scene.things() if state is problem.state else None
    batch, stage, marks = event_batch(Trial(tree, root, state, found, actions, rows, scene))
    event = np.zeros(len(batch))
    if is_event := tree.nodes[root].type == "EVENT":
        learned = cost.log_probability(batch, true=not forbidden)
        # Where the words name a kind of action themselves, no learned score may outbid them.
        event = np.where(bool(found.asked) | _is_untaught(actions)[rows.action], UNTAUGHT, learned)
    theme_score, goal_score = (
        np.array([*(c.score if c else 0.0 for c in some), 0.0])
        for some in (found.themes, found.goals)
    )
    total = before.score + event + theme_score[rows.theme] + goal_score[rows.goal]
    asked_for = ActionCase(tree, root, state, found, actions, problem)
    ruled = {} if forbidden else added_by(asked_for)
    total = total + sum(ruled.values(), np.zeros(len(actions)))[rows.action]
    goal_path = np.zeros(len(batch))
    if found.goal_path >= 0:
        goal_path = PathFactor(tree, found.goal_path, stage, cost).scores(batch.figure, batch.goal)
        total = total + goal_path
    chosen: dict[int, tuple[FloatArray, IntArray]] = {}
    for path, bodies in marks.items():
        of_path = PathCase(tree, path, state, actions, found.paths[path], problem)
        chosen[path] = PathFactor(tree, path, stage, cost).best(
            bodies, of_path.marks, added(of_path)
        )
        total = total + chosen[path][0][rows.action]
    order = np.argsort(-total, kind="stable")
    besides = {name: scores[rows.action] for name, scores in ruled.items()}
    besides["goal"] = goal_score[rows.goal]
    ranked = _Ranked(actions, rows.action[order], order, besides)
    factors = _factors(tree, root, found, stage, batch) if problem.explain else []
    choices = _choices([(found.themes, rows.theme), (found.goals, rows.goal)], total)
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
        nodes[root] = ((agent,) if is_event else (Path(agent.trajectory),), float(event[i]))
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
            (*before.goals, *((goal.group,) if goal and goal.nodes else ())),
            {**before.reasons, **_reasons(root, factors, cost, ranked, a)},
            {**before.choices, **choices},
            {**before.problems, **_problems(found, theme, goal)} if problem.explain else {},
            before.undone,
            (*before.clauses, root),
        )


def _allowed(
    tree: Tree, root: int, state: State, found: Arguments, problem: GroundingProblem
) -> list[Action]:
    """Return the possible actions, without those on loads that must not be handled.

    A clause about one load of several handles that one, or it can't be carried out.
    """
    possible = possible_actions(state, focus_of(state, found))
    possible = [action for action in possible if action.object_id not in problem.ruled_out]
    if state.held is not None and tree.once(_is_kept):
        possible = [action for action in possible if not action.kind.leaves]
    own = frame(tree, root)
    if own.frees:
        possible = [a for a in possible if a.kind.leaves or not a.object_id]
    if problem.only and own.handles:
        return [action for action in possible if action.object_id == problem.only]
    return possible


def _is_kept(tree: Tree) -> bool:
    """Check that a command says to put nothing down, and never to put it somewhere else."""
    frames = [frame(tree, n) for n in asked(tree) if tree.nodes[n].type == "EVENT"]
    puts = [own for own in frames if own.classes == {"placing"}]
    named = (tree.nodes[n] for own in puts for n in own.objects)
    return (
        bool(puts)
        and all(own.negated and not (own.places or own.paths) for own in puts)
        and all(is_pronoun(sdc) for sdc in named)
    )


def _is_untaught(actions: Sequence[Action]) -> BoolArray:
    """Check for actions of kinds that are only done on request, shape (n,)."""
    return np.array([action.kind.on_request for action in actions], dtype=bool)


def _choices(
    parts: Sequence[tuple[Sequence[Candidate | None], IntArray]], total: FloatArray
) -> dict[int, Choices]:
    """Return the best total of each grounding of each clause.

    Parameters
    ----------
    parts
        Candidates of themes or goals, and which of them each row has, -1 for none, shape (n,).
    total
        Scores of the rows, shape (n,).
    """
    best: dict[int, dict[tuple[int, ...], tuple[Group, float]]] = {}
    for candidates, index in parts:
        for i, candidate in enumerate(candidates):
            if candidate is None or not (own := total[index == i]).size:
                continue
            for node, (group, _) in candidate.nodes.items():
                known = best.setdefault(node, {})
                key = tuple(id(g) for g in group)
                before = known[key][1] if key in known else -np.inf
                known[key] = group, max(before, float(own.max()))
    return {n: tuple(sorted(known.values(), key=lambda c: -c[1])) for n, known in best.items()}


@dataclass(frozen=True, slots=True, eq=False)
class _Ranked:
    """Combinations of actions, themes and goals, the best first: actions, and rows of batches.

    In addition to its factors, a combination has scores, by row, of its goal and of potentials.
    """

    actions: Sequence[Action]
    action: IntArray
    row: IntArray
    besides: Mapping[str, FloatArray]


def _factors(
    tree: Tree, root: int, found: Arguments, stage: Stage, batch: FactorBatch
) -> list[FactorBatch]:
    """Return the factors of an EVENT and of the PATH that leads to its goal, with the same rows."""
    factors = [batch] if tree.nodes[root].type == "EVENT" else []
    if found.goal_path >= 0:
        factors.append(path_batch(tree, found.goal_path, stage, batch.figure, batch.goal))
    return factors


def _reasons(
    root: int, factors: Sequence[FactorBatch], cost: Cost, ranked: _Ranked, action: int
) -> dict[int, Reasons]:
    """Return the reasons for an action rather than the best one that does something else."""
    if not factors or not isinstance(cost, Scorer):
        return {}
    chosen = ranked.actions[action]
    other = np.array([_differs(a, chosen) for a in ranked.actions])[ranked.action]
    if not other.any():
        return {}
    first, best = (int(np.flatnonzero(x)[0]) for x in (ranked.action == action, other))
    rows = int(ranked.row[first]), int(ranked.row[best])
    rival = ranked.actions[int(ranked.action[best])]
    besides = {name: float(x[rows[0]] - x[rows[1]]) for name, x in ranked.besides.items()}
    taught = not _is_untaught((chosen, rival)).any()
    learned = [b for b in factors if taught or SDC_TYPES[int(b.type[0])] != "EVENT"]
    reasons = [r for batch in learned for r in reasons_against(batch, rows, cost)]
    return {root: (rival, tuple(weightiest([*reasons, *told_besides(besides.items())])))}


def _differs(action: Action, other: Action) -> bool:
    """Check that two actions do different things: not the same a little further on.

    Nor the same with another load: the theme's own reasons explain why it isn't that one.
    """
    if action.object_id and other.object_id and action.object_id != other.object_id:
        return False
    if action.place is not None and other.place is not None:
        apart = np.linalg.norm(centre(action.place.prism) - centre(other.place.prism))
        return action.kind != other.kind or bool(apart > OTHER_PLACE_M)
    return (action.kind, action.target, action.amount) != (other.kind, other.target, other.amount)


def _meant(before: Hypothesis) -> frozenset[str]:
    """Return the ids of the groundings of the clauses so far, without the robot."""
    things = (g for group, _ in before.nodes.values() for g in group)
    ids = {g.id for g in things if isinstance(g, PhysicalObject)}
    return frozenset(ids - {before.state.context.agent_id})


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


def prepared(tree: Tree, problem: GroundingProblem) -> GroundingProblem:
    """Return the problem with what all plans for a tree need: leaves, and what is ruled out."""
    problem = replace(problem, leaves=leaf_scores(tree, problem.scene, problem.cost))
    return replace(problem, ruled_out=ruled_out(tree, problem))


def search(
    tree: Tree, start: State, problem: GroundingProblem, *, width: int = WIDTH
) -> list[Hypothesis]:
    """Return the best plans for a :func:`prepared` problem, the best first."""
    beam = [Hypothesis(0.0, start)]
    left = list(in_order(tree, holds=start.held is not None))
    while left and beam:
        best = beam[0]  # all hypotheses carry the same loads, those that the best one means
        swapped = exchange(tree, left[0], best.state, problem)
        if swapped is not None:
            beam, left = [_exchanged(best, left[0], *swapped)], left[1:]
            continue
        request = next_request(tree, left, problem, best.state, best.nodes)
        beam = _each(tree, request, beam, problem, width) or _steps(
            tree, request.clauses, beam, problem, width
        )
        left = left[len(request.clauses) :]
    return beam


def _exchanged(
    before: Hypothesis,
    root: int,
    actions: tuple[Action, ...],
    nodes: Mapping[int, tuple[Group, float]],
) -> Hypothesis:
    """Return a hypothesis that continues with an exchange of two loads."""
    return replace(
        before,
        score=before.score + sum(score for _, score in nodes.values()),
        state=after_actions(before.state, actions),
        actions=(*before.actions, *actions),
        clauses=(*before.clauses, *(root for _ in actions)),
        nodes={**before.nodes, **nodes},
    )


def _steps(
    tree: Tree,
    clauses: Sequence[int],
    beam: Sequence[Hypothesis],
    problem: GroundingProblem,
    width: int,
) -> list[Hypothesis]:
    """Return the hypotheses that continue with some top-level clauses, the best first."""
    beam = list(beam)
    for root in clauses:
        beam = _step(tree, root, beam, problem, width)
    return beam


def _each(
    tree: Tree,
    request: Request,
    beam: Sequence[Hypothesis],
    problem: GroundingProblem,
    width: int,
) -> list[Hypothesis]:
    """Return the hypotheses that carry out a request for each of its loads; none if none can be.

    The first load is carried in several ways, the others in one, where that can be. Loads for which
    there is no room, or no way, stay where they are, and are named.
    """
    done = list(beam)
    first_actions: tuple[Action, ...] = ()
    carried: list[str] = []
    undone: list[str] = []
    for load in request.loads:
        own = _of_load(tree, load, replace(problem, only=load[request.theme]), done[0], carried)
        # "On the ground" is near where a load was, not where the one before it was put.
        again = [replace(hypothesis, goals=beam[0].goals) for hypothesis in done]
        widths = (1, width) if carried else (width,)
        tried = (_steps(tree, request.clauses, again[:most], own, most) for most in widths)
        put = ([h for h in found if h.state.held is None] for found in tried)
        further = next(filter(None, put), [])
        if not carried:  # the others follow the first one: on the truck, or beside it
            first = load[request.theme]
            further = [h for h in further if _is_raised(h, first) == _is_raised(further[0], first)]
            first_actions = further[0].actions[len(beam[0].actions) :] if further else ()
        done = further or done
        (carried if further else undone).append(load[request.theme])
    if not carried:
        return []
    loads = [load[request.theme] for load in request.loads]
    together = beam[0].state.held is None and all(len(load) == 1 for load in request.loads)
    row = _in_row(beam[0], done[0], first_actions, loads) if together else None
    if row is not None:
        done, carried, undone = [row], loads, []
    return [_with_all(hypothesis, request.theme, carried, undone) for hypothesis in done]


def _in_row(
    before: Hypothesis, done: Hypothesis, actions: Sequence[Action], loads: Sequence[str]
) -> Hypothesis | None:
    """Return a plan that puts all loads in a row on the deck that the first one is put on.

    None if they are all on it as they are, or it has no room for them.
    """
    deck = carrier(done.state, loads[0])
    if deck is None or is_load(before.state, deck.id):
        return None
    under = [carrier(done.state, load) for load in loads]
    places = deck_row(before.state.thing(deck.id), before.state)
    if all(thing is not None and thing.id == deck.id for thing in under) or len(places) < len(
        loads
    ):
        return None
    steps = tuple(
        replace(
            action,
            object_id=action.object_id and load,
            place=None if action.place is None else place,
        )
        for load, place in zip(loads, places, strict=False)
        for action in actions
    )
    first = len(before.actions)
    clauses = done.clauses[first : first + len(actions)] * (len(steps) // len(actions))
    return replace(
        done,
        state=after_actions(before.state, steps),
        actions=(*before.actions, *steps),
        clauses=(*before.clauses, *clauses),
    )


def _of_load(
    tree: Tree,
    load: Mapping[int, str],
    problem: GroundingProblem,
    best: Hypothesis,
    carried: Sequence[str],
) -> GroundingProblem:
    """Return the problem in which a request's clauses are grounded for one of its loads.

    All loads go to the same place, in the same way as the first.
    """
    if not carried:
        return replace(problem, answers={**problem.answers, **one_each(load)})
    known = dict(load)
    for node, (group, _) in best.nodes.items():
        sdc = tree.nodes[node]
        is_thing = sdc.type == "OBJECT" and not is_pronoun(sdc) and len(group) == 1
        if is_thing and node not in known and isinstance(group[0], PhysicalObject):
            known[node] = group[0].id
    raised = _is_raised(best, carried[-1])
    again = after(tree, problem, best.state)
    answers = {**one_each(known), **problem.answers, **one_each(load)}
    return replace(again, answers=answers, raised=raised)


def _is_raised(hypothesis: Hypothesis, load: str) -> bool:
    """Check that a load stands on something at the end of a plan."""
    return carrier(hypothesis.state, load) is not None


def _with_all(
    hypothesis: Hypothesis, theme: int, carried: Sequence[str], undone: Sequence[str]
) -> Hypothesis:
    """Return a hypothesis in which a request's OBJECT means all loads that were carried."""
    nodes = dict(hypothesis.nodes)
    group = tuple(hypothesis.state.thing(name) for name in carried)
    if theme in nodes:
        nodes[theme] = group, nodes[theme][1]
    referents, left = (*hypothesis.referents, group), (*hypothesis.undone, *undone)
    return replace(hypothesis, nodes=nodes, referents=referents, undone=left)


def _step(
    tree: Tree, root: int, beam: Sequence[Hypothesis], problem: GroundingProblem, width: int
) -> list[Hypothesis]:
    """Return the hypotheses that continue with a top-level clause, the best first."""
    below = tree.all_below(root)
    turned = any(is_seen_later(tree, n) for n in below)
    if tree.nodes[root].type in ("OBJECT", "PLACE"):
        return _mentioned(tree, root, beam, problem, turned=turned)[:width]
    pronouns = [n for n in below if is_pronoun(tree.nodes[n])]
    own = frame(tree, root)
    said_there = any(is_there(tree.nodes[n]) for n in below)
    there = own.leaves_open or own.down or said_there
    named = any(
        names_other(tree.nodes[n]) or names_same(tree.nodes[n]) or names_again(tree, n)
        for n in below
    )
    stead = any(is_stead(tree.nodes[n]) for n in below)
    leads = bool(pronouns) or any(tree.nodes[n].type == "PLACE" for n in below)
    grounded: dict[tuple[object, ...], Arguments] = {}
    grown: list[Hypothesis] = []
    for before in beam:
        spoken = before.referents if pronouns or own.takes_unnamed or stead else ()
        goals = before.goals if there else ()
        if any(is_on_top(tree.nodes[n]) for n in below):
            under = _carriers(before, problem.state, before.state)
            goals = under or goals or _decks(problem.state)
        elif said_there and not goals:
            goals = _carriers(before, problem.state) or _spoken_of(tree, root, before)
        meant_before = _meant(before) if named else frozenset()
        meant = {
            n: tuple(
                (before.nodes[x.index][0], x.probability)
                for x in tree.antecedents.get(n, ())
                if x.index in before.nodes
            )
            for n in pronouns
        }
        moved = leads and any(action.object_id for action in before.actions)
        later = before.state if turned or goals or moved else None
        seen = id(later) if turned or goals else _places(before.state, problem.state)
        key = (spoken, goals, meant_before, before.state.held, seen, *meant.values())
        if key not in grounded:
            around = replace(
                problem,
                referents=spoken,
                antecedents=meant,
                goals=goals,
                spoken=meant_before,
                load=before.state.held,
                held=before.state.held,
                told_side=told_side(tree, root),
                later=later,
            )
            grounded[key] = arguments(tree, root, around)
        grown += islice(extend(tree, root, before, grounded[key], problem), width)
    return sorted(grown, key=lambda h: -h.score)[:width]


def _carriers(before: Hypothesis, *states: State) -> tuple[Group, ...]:
    """Return what the loads that were handled stand on in some states."""
    handled = [action.object_id for action in before.actions if action.object_id]
    under = [carrier(state, load) for load in handled for state in states]
    return tuple((thing,) for thing in under if thing is not None)


def _decks(state: State) -> tuple[Group, ...]:
    things = (o for o in state.context.objects if not is_load(state, o.id))
    return tuple((o,) for o in things if is_surface(o))


def _spoken_of(tree: Tree, root: int, before: Hypothesis) -> tuple[Group, ...]:
    """Return what places were about that were only named: "the barrel is full, put it there"."""
    named = (n for n in range(root) if tree.nodes[n].type == "PLACE")
    marks = (mark for place in named for mark in tree.below(place, ("l",), "OBJECT"))
    return tuple(before.nodes[mark][0] for mark in marks if mark in before.nodes)


def _places(now: State, before: State) -> tuple[tuple[object, ...], ...]:
    """Return where the things are that have been moved, to the centimetre."""
    pairs = zip(now.context.objects, before.context.objects, strict=True)
    return tuple(
        (a.id, *centre(a.prism).round(2).tolist(), round(a.prism.z_min, 2))
        for a, b in pairs
        if a is not b and a.id != now.context.agent_id
    )


def _mentioned(
    tree: Tree, root: int, beam: Sequence[Hypothesis], problem: GroundingProblem, *, turned: bool
) -> list[Hypothesis]:
    """Return hypotheses after a clause that only names: "the tires on the truck, lift them"."""
    found: dict[int, list[Candidate]] = {}
    grown = []
    for before in beam:
        later = before.state if turned else None
        if id(later) not in found:
            found[id(later)] = ground_thing(tree, root, replace(problem, later=later))
        grown += [
            replace(
                before,
                score=before.score + c.score,
                nodes={**before.nodes, **c.nodes},
                referents=(*before.referents, c.group),
            )
            for c in found[id(later)]
        ]
    return sorted(grown, key=lambda h: -h.score)
