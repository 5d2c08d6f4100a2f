"""The second verdict: agreement of an execution with the command's words, wherever the log ends.

It is independent of any model: it reads a command's annotated clauses and the geometry of the
world. Any thing, side or place that the words allow is right. A requested action that is missing is
wrong, and so is an action on a thing that the words don't mention.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from eval.judging.allowed_places import Ending, ends_well
from eval.judging.allowed_things import allowed
from eval.judging.execution import Carried, Execution
from eval.judging.grounded_command import GroundedCommand, grounded_command
from eval.judging.judge import END_M, MOVED_M, PLACE_M, Verdict
from eval.judging.judged_clauses import JudgedClause, judged_clauses, themes_of
from eval.judging.layout import NEAR_M, nearest, seen
from g3.actions.grounding_candidates import carrier, is_surface
from g3.actions.robot_state import moved_to
from g3.annotation import Annotation
from g3.geometry.footprints import apart
from g3.groundings import FloatArray
from g3.inference.problem.clause_roles import is_source, ways
from g3.inference.problem.phrases import unstressed
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.word_sets import HANDLING_VERBS

ROWS = 60
"""Number of points of the path at which positions are checked."""
TURN = np.pi / 6
"""Smallest angle of a turn to a side, in radians."""
ASIDE_M = 1.0
"""Smallest distance to a side that replaces a turn, in metres."""


def judge_by_words(annotation: Annotation, execution: Execution) -> Verdict:
    """Compare an execution, in the command's own world or another, with its words."""
    words = grounded_command(annotation, execution.start)
    clauses = judged_clauses(words)
    handles = any(c.handles for c in clauses)
    reason = (_wrong if handles else _misdriven)(words, clauses, execution)
    return Verdict(not reason, reason)


def _misdriven(
    words: GroundedCommand, clauses: Sequence[JudgedClause], execution: Execution
) -> str:
    """Return the error of a command that only drives; empty if there is none."""
    if any(c.id != execution.start.held or c.lowered is not None for c in execution.carried):
        return "it moves a load, of which the words don't speak"
    if any("staying" not in c.verbs for c in clauses) and not _drives(execution.way):
        return "the robot stays where it is"
    return _astray(words, clauses, execution)


def _wrong(words: GroundedCommand, clauses: Sequence[JudgedClause], execution: Execution) -> str:
    """Return the error of a command that handles a load; empty if there is none."""
    themes = themes_of(words, clauses)
    wanted = frozenset(i for ids in themes.values() for i in ids)
    strange = [c.id for c in execution.carried if themes and c.id not in wanted]
    if strange:
        return f"it moves {', '.join(strange)}, which the words don't speak of"
    if len(execution.carried) > max(sum(map(len, themes)), 1):
        return "it moves more than the words say"
    for theme, ids in themes.items() if themes else [(None, None)]:
        loads = [c for c in execution.carried if ids is None or c.id in ids]
        if len(loads) < max(len(theme or ()), 1):
            return "it doesn't move what the words say"
        own = [c for c in clauses if c.handles and (theme is None or theme in c.themes)]
        for load in loads:
            reason = _mishandled(words, own, load, execution)
            if reason:
                return reason
    return _astray(words, clauses, execution)


def _mishandled(
    words: GroundedCommand, clauses: Sequence[JudgedClause], load: Carried, execution: Execution
) -> str:
    """Return the error in how a load is handled; later handling is no error."""
    sources = [
        n for c in clauses for n in ways(words.tree, c.root) if is_source(words.tree.nodes[n])
    ]
    if not all(_comes_from(words, node, load.id) for node in sources):
        return "it isn't taken from where the words say"
    first, last = execution.start.thing(load.id), execution.end.thing(load.id)
    held = load.lowered is None
    short = held and not execution.whole
    ending = Ending(load.id, first.prism, last.prism, execution.end, short)
    if held and load.id == execution.start.held and apart(first.prism, last.prism) < MOVED_M:
        return "nothing is done with the load on the forks"
    verbs = clauses[-1].verbs & HANDLING_VERBS
    if held and verbs == {"placing"} and not (short and clauses[-1].goals):
        return "the load isn't put down"
    told_where = [c.goals for c in clauses if c.goals]
    only_taken = not told_where and all(c.verbs & HANDLING_VERBS == {"taking"} for c in clauses)
    if execution.whole and only_taken and not held:
        return "it puts down what it is only to pick up"
    return _misplaced(words, told_where[-1], ending) if told_where else ""


def _misplaced(words: GroundedCommand, goals: Sequence[int], ending: Ending) -> str:
    holds = ends_well(words, goals, ending)
    if holds is None:
        return _unlike_log(words, ending, PLACE_M)
    return "" if holds else "the load doesn't end where the words say"


def _unlike_log(words: GroundedCommand, ending: Ending, tolerance_m: float) -> str:
    """Return the difference from the own log, for unmeasurable words; empty elsewhere."""
    if words.state_after is None:
        return ""
    goal = words.state_after.thing(ending.thing).prism
    off = apart(goal, ending.last) - ending.slack
    if off <= tolerance_m:
        return ""
    return f"the words can't be measured, and it ends {off:.1f} m from where the log ends"


def _comes_from(words: GroundedCommand, node: int, load: str) -> bool:
    marks = words.tree.below(node, ("l", "l2"), "OBJECT")
    sources = frozenset(i for n in marks for i in allowed(words, n) | words.things[n])
    things = [words.state.thing(i) for i in sorted(sources - {words.robot, load})]
    if not things:
        return True
    under = carrier(words.state, load)
    if under is not None:
        return under.id in sources
    # A load that is on the forks at first may have been taken from a deck before.
    near = nearest(words.state.thing(load).prism, [o.prism for o in things]) <= NEAR_M
    return near and (load == words.state.held or not any(map(is_surface, things)))


def _astray(words: GroundedCommand, clauses: Sequence[JudgedClause], execution: Execution) -> str:
    """Return the error in the robot's path; the clauses' goals come in their order."""
    end = len(execution.way) - 1
    row, measured = 0, any(c.handles for c in clauses)
    # A log that starts with the load on the forks doesn't show how the robot came to it.
    late = any(c.lifted == 0 for c in execution.carried) and measured
    moving = [c for c in clauses if c.verbs != {"staying"}]
    for clause in moving:
        late &= not clause.handles
        if late or clause.handles:
            continue
        if not _turns(words, clause, execution.way[row:]):
            return "the robot doesn't turn as the words say"
        rows = np.unique(np.linspace(row, end, ROWS).astype(int)).tolist()
        if any(_reached(words, (n,), execution, rows) is False for n in clause.passed):
            return "the robot doesn't pass as the words say"
        last = clause is moving[-1]
        reached = _reached(words, clause.goals, execution, [end] if last else rows)
        if reached is False:
            return f"the robot doesn't {'end' if last else 'come'} where the words say"
        measured |= reached is not None
        row = row if reached is None else int(reached)
    return "" if measured else _unlike_log(words, _robot(execution, end), END_M)


def _reached(
    words: GroundedCommand, nodes: Sequence[int], execution: Execution, rows: Sequence[int]
) -> int | bool | None:
    """Return the first row at which clauses hold; False if none, None if unknown."""
    known = False
    for row in rows:
        holds = ends_well(words, nodes, _robot(execution, row))
        if holds:
            return row
        known |= holds is not None
    return False if known else None


def _turns(words: GroundedCommand, clause: JudgedClause, way: FloatArray) -> bool:
    """Check that the robot turns or drives to the side that a clause without a goal states."""
    side = concepts(unstressed(field_words(words.tree.nodes[clause.root].relation))) & {
        "left",
        "right",
    }
    if len(side) != 1:
        return True
    sign = 1.0 if "left" in side else -1.0
    turned = sign * np.unwrap(way[:, 2])
    aside = sign * seen(way[0], way[:, :2])[:, 1]
    return bool((turned - turned[0]).max() >= TURN or aside.max() >= ASIDE_M)


def _drives(way: FloatArray) -> bool:
    """Check that the robot drives or turns at all."""
    far = np.linalg.norm(way[:, :2] - way[0, :2], axis=1).max() > MOVED_M
    return bool(far or np.ptp(np.unwrap(way[:, 2])) >= TURN)


def _robot(execution: Execution, row: int) -> Ending:
    robot = execution.start.context.agent
    there = moved_to(robot, execution.way[row], robot.prism.z_min)
    state = execution.end if row == len(execution.way) - 1 else execution.start
    return Ending(robot.id, robot.prism, there.prism, state, robot=True)
