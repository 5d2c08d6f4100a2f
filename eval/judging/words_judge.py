"""The second verdict: whether what was done is what the words say, wherever the log ends.

It is independent of any model: it reads a command's annotated clauses and the geometry of the
world. Any thing, side or place that the words allow is right. What the words ask for and isn't
done is wrong, and so is what is done to a thing they don't speak of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eval.judging.allowed_places import Ending, ends_well
from eval.judging.allowed_things import NEAR_M, allowed
from eval.judging.deeds import Carried, Deeds
from eval.judging.judge import MOVED_M, Verdict
from eval.judging.layout import nearest, seen
from eval.judging.worded import Worded, worded
from g3.actions.grounding_candidates import carrier, is_surface
from g3.actions.logged_actions import centre
from g3.actions.robot_state import moved_to
from g3.annotation import Annotation
from g3.groundings import FloatArray
from g3.inference.problem.clause_roles import (
    goal_paths,
    goal_places,
    goal_within,
    is_source,
    names_own_forks,
    objects,
    spares,
    ways,
)
from g3.inference.problem.phrases import is_pronoun, is_there, told, verb_class
from g3.language.discourse.negation import negated
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.word_sets import HANDLING_VERBS

ROWS = 60
"""At so many points of its way it is looked whether the robot comes by something."""
TURN = np.pi / 6
"""A turn to a side is at least so wide,"""
ASIDE_M = 1.0
"""or leads so far to it."""


@dataclass(frozen=True, slots=True)
class _Clause:
    """A top-level EVENT as it is judged: what it handles, and where that or the robot is to go."""

    root: int
    verbs: frozenset[str]
    themes: tuple[int, ...]
    goals: tuple[int, ...]


def judge_by_words(annotation: Annotation, deeds: Deeds) -> Verdict:
    """Compare what was done with the words of an annotated command."""
    words = worded(annotation, deeds.start)
    clauses = _clauses(words)
    handled = [c for c in clauses if c.themes]
    moved = [c for c in deeds.carried if _shift(deeds, c) > MOVED_M]
    groups = _themes(words, handled)
    if not groups:
        return _driven(words, clauses, deeds, moved)
    wanted = frozenset(i for ids in groups.values() for i in ids)
    strange = [c.id for c in moved if c.id not in wanted]
    if strange:
        return Verdict(False, f"it moves {', '.join(strange)}, which the words don't speak of")
    for ids in groups.values():
        loads = [c for c in deeds.carried if c.id in ids]
        if not loads:
            return Verdict(False, "it doesn't move what the words say")
        reason = _handled(words, handled, ids, loads[0], deeds)
        if reason:
            return Verdict(False, reason)
    return _visits(words, clauses, deeds)


def _clauses(words: Worded) -> list[_Clause]:
    tree = words.tree
    found: list[_Clause] = []
    last: tuple[int, ...] = ()
    for root in range(len(tree.sdcs)):
        sdc = tree.nodes[root]
        if sdc.type != "EVENT" or negated(sdc) or names_own_forks(tree, root):
            continue
        if spares(tree, root, words.state.held):
            continue
        verbs = frozenset(verb_class(sdc).split("+"))
        named = objects(tree, root)
        things = [n for n in named if words.things[n] and words.robot not in words.things[n]]
        themes: tuple[int, ...] = ()
        if verbs & HANDLING_VERBS or (things and "other" in verbs) or _company(words, root):
            # What no clause names is what was spoken of before: "deposit there".
            themes = tuple(things[:1]) if named else last
            last = themes or last
        goals = [n for n in goal_places(tree, root) if not is_there(tree.nodes[n])]
        goals += [n for n in goal_paths(tree, root) if not is_there(tree.nodes[n])]
        within = goal_within(tree, root)
        goals += [] if within is None else [within]
        found.append(_Clause(root, verbs, themes, tuple(goals)))
    return found


def _company(words: Worded, root: int) -> bool:
    """Whether a clause tells what goes along: "back up with the pallet"."""
    return "with" in {w.text.lower() for w in words.tree.nodes[root].relation}


def _themes(words: Worded, handled: list[_Clause]) -> dict[frozenset[str], frozenset[str]]:
    """By the annotated things, those that may be handled instead of them."""
    found: dict[frozenset[str], frozenset[str]] = {}
    for clause in handled:
        more = tuple(
            w
            for n in ways(words.tree, clause.root)
            if is_source(words.tree.nodes[n]) and not words.tree.nodes[n].landmark1
            for w in words.tree.nodes[n].relation
        )
        for key in {words.things[node] for node in clause.themes}:
            named = _names(words, key)
            own = [allowed(words, node, more if node in clause.themes else ()) for node in named]
            found[key] = frozenset.intersection(found.get(key, own[0]), *own) if own else key
    return found


def _names(words: Worded, things: frozenset[str]) -> list[int]:
    """The outermost OBJECTs that name things, without pronouns."""
    tree = words.tree
    own = [n for n, sdc in enumerate(tree.nodes) if sdc.type == "OBJECT" and words.things[n] == things]
    inside = {c for n in own for field in tree.children[n].values() for c in field}
    return [n for n in own if n not in inside and not is_pronoun(tree.nodes[n])]


def _handled(
    words: Worded, clauses: list[_Clause], ids: frozenset[str], load: Carried, deeds: Deeds
) -> str:
    """What is wrong with how a load is handled; empty if nothing is."""
    mine = clauses
    for clause in mine:
        for node in ways(words.tree, clause.root):
            if is_source(words.tree.nodes[node]) and not _comes_from(words, node, load.id):
                return "it isn't taken from where the words say"
    first, last = deeds.start.thing(load.id), deeds.end.thing(load.id)
    ending = Ending(load.id, first.prism, last.prism, deeds.end, load.lowered is None)
    final = [c for c in mine if c.goals]
    if final and ends_well(words, final[-1].goals, ending) is False:
        return "the load doesn't end where the words say"
    placed = mine[-1].verbs & HANDLING_VERBS == {"placing"}
    if placed and ending.short and not mine[-1].goals:
        return "the load isn't put down"
    return ""


def _comes_from(words: Worded, node: int, load: str) -> bool:
    tree = words.tree
    marks = tree.below(node, ("l", "l2"), "OBJECT")
    sources = frozenset(i for n in marks for i in allowed(words, n) | words.things[n])
    sources -= {words.robot, load}
    if not sources:
        return True
    under = carrier(words.state, load)
    if under is not None:
        return under.id in sources
    # A load that is on the forks at first may have been taken from there before.
    things = [words.state.thing(i) for i in sources]
    decks = any(is_surface(o) for o in things) and load != words.state.held
    near = nearest(words.state.thing(load).prism, [o.prism for o in things]) <= NEAR_M
    return near and not decks


def _driven(
    words: Worded, clauses: list[_Clause], deeds: Deeds, moved: list[Carried]
) -> Verdict:
    if any(c.id != deeds.start.held or c.lowered is not None for c in moved):
        return Verdict(False, "it moves a load, of which the words don't speak")
    return _visits(words, clauses, deeds)


def _visits(words: Worded, clauses: list[_Clause], deeds: Deeds) -> Verdict:
    """Whether the robot comes by what driving clauses name, in their order, and ends there."""
    row, end = 0, len(deeds.way) - 1
    first = min((c.lifted for c in deeds.carried), default=0)
    begun = not any(c.themes for c in clauses) or first > 0
    for number, clause in enumerate(clauses):
        if clause.themes:
            begun = True
            continue
        if not begun:
            continue
        if not clause.goals:
            if not _turns(words, clause, deeds.way[row:]):
                return Verdict(False, "the robot doesn't turn as the words say")
            continue
        last = number == len(clauses) - 1
        if last:
            if ends_well(words, clause.goals, _robot(words, deeds, end)) is False:
                return Verdict(False, "the robot doesn't end where the words say")
            continue
        rows = np.unique(np.linspace(row, end, ROWS).astype(int))
        holds = [ends_well(words, clause.goals, _robot(words, deeds, r)) for r in rows]
        if None in holds:
            continue
        if not any(holds):
            return Verdict(False, "the robot doesn't come by what the words say")
        row = int(rows[holds.index(True)])
    return Verdict(True)


def _turns(words: Worded, clause: _Clause, way: FloatArray) -> bool:
    """Whether the robot turns or drives to the side that a clause without a goal tells."""
    side = concepts(told(field_words(words.tree.nodes[clause.root].relation))) & {"left", "right"}
    if len(side) != 1:
        return True
    sign = 1.0 if "left" in side else -1.0
    turned = sign * np.unwrap(way[:, 2])
    aside = sign * seen(way[0], way[:, :2])[:, 1]
    return bool((turned - turned[0]).max() >= TURN or aside.max() >= ASIDE_M)


def _robot(words: Worded, deeds: Deeds, row: int) -> Ending:
    robot = deeds.start.context.agent
    pose: FloatArray = deeds.way[row]
    there = moved_to(robot, pose, robot.prism.z_min)
    state = deeds.end if row == len(deeds.way) - 1 else deeds.start
    return Ending(robot.id, robot.prism, there.prism, state)


def _shift(deeds: Deeds, load: Carried) -> float:
    ends = (centre(s.thing(load.id).prism) for s in (deeds.start, deeds.end))
    first, last = ends
    return float(np.linalg.norm(last - first))
