"""Requests in a command's clauses: the loads to handle, and goals for loads or the robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from eval.judging.allowed_things import allowed
from eval.judging.grounded_command import GroundedCommand, Things
from g3.actions.grounding_candidates import is_surface
from g3.inference.problem.clause_roles import is_goal, is_source, tells_place, ways
from g3.inference.problem.frames import Frame, asked, frame, spares
from g3.inference.problem.phrases import is_pronoun, is_there
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, field_words
from g3.language.lexicon.word_sets import COPULAS
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class JudgedClause:
    """A top-level EVENT."""

    root: int
    verbs: frozenset[str]
    """Classes of its verb."""
    handles: bool
    """True if the clause handles a load; otherwise the robot drives."""
    themes: tuple[Things, ...]
    """Loads to handle, as annotated: sets of ids. None if the clause states none, or names
    carriers."""
    goals: tuple[int, ...]
    """Clauses that state the goal of the load, or of the robot."""
    passed: tuple[int, ...]
    """Clauses that state landmarks for the robot to pass."""


def judged_clauses(words: GroundedCommand) -> list[JudgedClause]:
    """Return the clauses that request actions, in order."""
    tree = words.tree
    found: list[JudgedClause] = []
    spoken: tuple[Things, ...] = ()
    for root in asked(tree):
        sdc, own = tree.nodes[root], frame(tree, root)
        if sdc.type != "EVENT" or own.negated or spares(tree, root, words.state.held):
            continue
        if "there" in (said := {bare(w.text) for w in sdc.relation}) and said & COPULAS:
            # "There are two crates" asks for nothing.
            continue
        verbs = own.classes
        named = [n for n in own.objects if words.robot not in words.things[n]]
        robot = len(named) < len(own.objects)
        loads = [n for n in named if words.annotated[n] and not _is_carrier(words, n)]
        handles = own.forks or (_handles(words, own, loads) and bool(loads or not robot))
        if not own.forks and not named and not spoken:
            # Without anything on the forks "move forward" and "park" speak of the robot.
            handles &= words.state.held is not None and not verbs & {"carrying", "staying"}
        themes: tuple[Things, ...] = ()
        if handles:
            # What a clause doesn't name is what was spoken of before: "deposit there".
            themes = tuple(words.annotated[n] for n in loads[:1]) if named else spoken
            spoken = themes or spoken
        goals, passed = _where(words, own, drives=not handles)
        found.append(JudgedClause(root, verbs, handles, themes, goals, passed))
    return found


def themes_of(words: GroundedCommand, clauses: Sequence[JudgedClause]) -> dict[Things, Things]:
    """Map annotated loads to all that the words allow instead."""
    found: dict[Things, Things] = {}
    for theme in (theme for clause in clauses for theme in clause.themes):
        more = tuple(
            word
            for clause in clauses
            if theme in clause.themes
            for n in ways(words.tree, clause.root)
            if is_source(words.tree.nodes[n]) and not words.tree.nodes[n].landmark1
            for word in words.tree.nodes[n].relation
        )
        own = [allowed(words, node, more) for node in _names(words, theme)]
        found[theme] = frozenset.intersection(*own) if own else _now(words, theme)
    return found


def _now(words: GroundedCommand, theme: Things) -> Things:
    """Resolve a theme that is only ever a pronoun to objects in the world."""
    return next(t for a, t in zip(words.annotated, words.things, strict=True) if a == theme)


def _handles(words: GroundedCommand, own: Frame, loads: Sequence[int]) -> bool:
    if own.handles and not own.guessed:
        return True
    # "Back up with the pallet".
    unknown = own.guessed or not own.classes
    relation = words.tree.nodes[own.node].relation
    return bool(loads) and (unknown or "with" in {bare(word.text) for word in relation})


def _is_carrier(words: GroundedCommand, node: int) -> bool:
    things = [words.state.thing(i) for i in words.things[node]]
    return bool(things) and all(map(is_surface, things))


def _where(
    words: GroundedCommand, own: Frame, *, drives: bool
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return a clause's goals, and landmarks to pass: "between the cones to the truck"."""
    tree, paths, places = words.tree, own.paths, own.places
    within = [n for n in (own.end,) if n is not None]
    to = [n for n in paths if is_goal(tree.nodes[n])]
    if drives:
        named = [n for n in own.objects if words.robot not in words.things[n]]
        comes = "to" in concepts(field_words(tree.nodes[own.node].relation))
        # "Until you have passed the barrel" needn't end there.
        ends = [*to, *(n for n in within if tree.nodes[n].type == "PLACE")] or places
        ends = ends or (named if comes else [])
    else:
        ends = [*places, *to, *(n for n in paths if tells_place(tree.nodes[n])), *within]
    goals = [n for n in dict.fromkeys(ends) if not is_there(tree.nodes[n])]
    return tuple(goals), tuple(n for n in (*paths, *places, *within) if n not in ends)


def _names(words: GroundedCommand, things: Things) -> list[int]:
    """Return the outermost OBJECTs that name things, without pronouns."""
    tree = words.tree
    own = [
        n
        for n, sdc in enumerate(tree.nodes)
        if sdc.type == "OBJECT" and words.annotated[n] == things
    ]
    inside = {c for n in own for field in tree.children[n].values() for c in field}
    return [n for n in own if n not in inside and not is_pronoun(tree.nodes[n])]
