"""From a command and a context to a plan: the whole of inference in one call (section 3.4)."""

from __future__ import annotations

import importlib.metadata
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from g3 import html_view
from g3.actions.action_kinds import Action, move, result
from g3.actions.action_words import PlanWords
from g3.actions.robot_state import State, start_state
from g3.data_frames import data_frame
from g3.errors import AnswerError, ModelError
from g3.groundings import Context, FloatArray, Grounding, Place, Trajectory, object_ids
from g3.inference.absence import absent_nouns, what_is_missing
from g3.inference.calibration import LEAST_FIT, evidence, odds, plan_probability
from g3.inference.clarification import Question, question_about, understood
from g3.inference.plan_things import PlanEnd, left_aside, named_things
from g3.inference.potentials.cases import CommandCase
from g3.inference.potentials.potential_registry import check_potentials, refusal
from g3.inference.problem.asked_kinds import asks_for_way, asks_to_wait
from g3.inference.problem.asked_spots import scene_asked
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost, Scorer
from g3.inference.problem.frames import asked, frame
from g3.inference.problem.grounding_problem import Candidate, GroundingProblem, one_each
from g3.inference.problem.later_sides import any_seen_later
from g3.inference.problem.packed_scene import Group
from g3.inference.problem.plain_clauses import plain
from g3.inference.problem.scoring import Reason
from g3.inference.problem.untaught_words import untaught_words
from g3.inference.problem.world_nouns import Nouns
from g3.inference.reasons.explanation import reasons_for_things
from g3.inference.search.action_search import WIDTH, Hypothesis, prepared, search
from g3.inference.search.thing_search import ground_others, ground_thing
from g3.inference.tree_choice import (
    LOOKED_AT,
    PARSES,
    PROPOSED,
    Choice,
    all_plans,
    best_plans,
    does_something,
)
from g3.language.discourse.negation import negated
from g3.language.lexicon.field_words import bare, text_words
from g3.language.lexicon.measures import metres_said
from g3.language.similarity.learned_lexicon import Lexicon
from g3.learning.grounding_model import GroundingModel
from g3.learning.model_file import model_files
from g3.scene_drawing import Marks, scene_svg
from g3.sdc import sdc_drawing
from g3.sdc.clauses import SDC, all_words
from g3.short_repr import brief, short_repr

if TYPE_CHECKING:
    import pandas as pd

    from g3.inference.ends.end_model import EndModel, JointEnds
    from g3.language.parsing.trees import Parse


def plan_marks(
    start: State, actions: Sequence[Action], groundings: Iterable[Sequence[Grounding]]
) -> Marks:
    """Mark groundings, where loads are put down, and the robot's way in each action."""
    groups = list(groundings)
    places = [g for group in groups for g in group if isinstance(g, Place)]
    places += [a.place for a in actions if a.place is not None and a.place not in places]
    things = {name for group in groups for name in object_ids(group)}
    return Marks(things, places, _ways(start, actions))


def _ways(state: State, actions: Sequence[Action]) -> list[Trajectory]:
    ways = []
    for action in actions:
        motion = move(state, [action])
        ways.append(Trajectory(motion.t[0], motion.xyz[0], motion.yaw[0]))
        state = result(state, action, motion, 0)
    return ways


ENTRY_POINT_GROUP = "g3.models"


def open_model(model: GroundingModel | Path | str) -> GroundingModel:
    """Read a model, or get one by its name.

    Parameters
    ----------
    model
        ``NAME``, ``NAME.npz`` or ``NAME.json`` of a file; where there is none, the name of a model,
        such as ``warehouse``. A model is given back as it is.

    Raises
    ------
    ModelError
        If there is neither, or the file can't be used.
    """
    if isinstance(model, GroundingModel):
        return model
    if any(Path(file).exists() for file in model_files(model)):
        return GroundingModel.load(model)
    named = {p.name: p for p in importlib.metadata.entry_points(group=ENTRY_POINT_GROUP)}
    if str(model) not in named:
        more = "or train one and save() it"
        raise ModelError.unknown("file or model", str(model), sorted(named), more=more)
    return cast("GroundingModel", named[str(model)].load()())


GUESSED_RIGHT = 0.8
"""Probability that an unknown verb asks for an action that its arguments allow: assumed, for
corpora have few."""


@short_repr
@dataclass(frozen=True, slots=True)
class GroundedClause:
    """A clause with its groundings.

    Parameters
    ----------
    node
        Index of the clause in breadth-first order.
    sdc
        The clause.
    group
        Its grounding: objects, a place, or what the robot does.
    probability
        p(φ = true) of its factor.
    reasons
        Evidence for the grounding rather than for its rival, and against it; without a rival the
        evidence for it. Of clauses that name one thing, or one action, the outermost has all. Only
        of a learned cost.
    rival
        The best other action, or the best other thing; None where there is none.
    """

    node: int
    sdc: SDC
    group: tuple[Grounding, ...]
    probability: float
    reasons: tuple[Reason, ...] = ()
    rival: Action | Group | None = None

    @property
    def text(self) -> str:
        """The clause's words."""
        return " ".join(word.text for word in all_words(self.sdc))


@short_repr
@dataclass(frozen=True, slots=True)
class Plan:
    """One way to follow a command.

    Parameters
    ----------
    actions
        The actions, one after the other.
    probability
        Calibrated probability that it is the meant one.
    score
        Sum of the log-probabilities of all factors.
    groundings
        Groundings of every clause that has one, in breadth-first order.
    state
        The state after the plan.
    evidence
        The evidence that the probability was calibrated from (:mod:`g3.inference.calibration`).
    why_not
        Why it can't be carried out, such as a load that the forks don't reach; empty if nothing
        speaks against it, or nobody has looked.
    clauses
        Index of the clause that each action is for; "put both on it" has two.
    start
        The state before the plan, which names its places; None if that isn't known.
    """

    actions: tuple[Action, ...]
    probability: float
    score: float
    groundings: tuple[GroundedClause, ...]
    state: State
    evidence: tuple[float, ...] = ()
    why_not: str = ""
    clauses: tuple[int, ...] = ()
    start: State | None = field(default=None, repr=False, compare=False)

    @property
    def words(self) -> PlanWords:
        """Descriptions of its actions and groundings."""
        return PlanWords(self.start, self.actions)


@short_repr
@dataclass(frozen=True, slots=True)
class Result:
    """Result of a command.

    Parameters
    ----------
    sdcs
        The clauses.
    plans
        The best plans, the best first; none if there is nothing to do.
    note
        Why there is no plan; of a plan, which verbs and words of relations aren't known, so that it
        is a guess, which loads it leaves where they are, which things that the text names have no
        part in it, and whether all words led to it rather than a tree; else empty.
    question
        Question to ask back where it isn't clear which thing is meant; None if it is.
    missing
        Nouns that name nothing that there is. Then there is no plan, unless one was insisted on.
    start
        The state in which it was given, for pictures.
    """

    sdcs: tuple[SDC, ...]
    plans: tuple[Plan, ...]
    note: str = ""
    question: Question | None = None
    missing: tuple[str, ...] = ()
    start: State | None = field(default=None, repr=False, compare=False)

    @property
    def plan(self) -> Plan | None:
        """The best plan."""
        return self.plans[0] if self.plans else None

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each clause of the best plan: its words and its groundings."""
        found = self.plan.groundings if self.plan else ()
        words = self.plan.words if self.plan else PlanWords()
        return data_frame(
            {
                "words": clause.text,
                "clause": clause.sdc.type,
                "grounded_in": words.group(clause.group),
                "probability": clause.probability,
            }
            for clause in found
        )

    def _repr_html_(self) -> str:
        """Show the clauses, and the best plan with a map of its groundings and its ways."""
        said = [sdc_drawing.to_svg(self.sdcs)] if self.sdcs else []
        said += [html_view.paragraph(words) for words in self._words() if words]
        plan = self.plan
        if plan is None:
            return "\n".join(said or [html_view.paragraph("no plan")])
        groups = [clause.group for clause in plan.groundings]
        if self.start is not None:
            marks = plan_marks(self.start, plan.actions, groups)
            said.append(scene_svg(self.start.context, marks))
        words = plan.words
        steps = [(n, words.action(a)) for n, a in enumerate(plan.actions, start=1)]
        rows = [
            (c.text, c.sdc.type, words.group(c.group), f"{c.probability:.2f}")
            for c in plan.groundings
        ]
        if plan.why_not:
            said.append(html_view.paragraph(f"it can't be carried out: {plan.why_not}"))
        return "\n".join(
            [
                *said,
                html_view.heading("Plan", f"probability {plan.probability:.2f}"),
                html_view.table(("", "what is done"), steps),
                html_view.table(("words", "clause", "grounded in", "fits"), rows),
            ]
        )

    def _words(self) -> tuple[str, ...]:
        missing = f"there is no {' and no '.join(self.missing)} here" if self.missing else ""
        return (self.note, missing, self.question.text if self.question else "")


SURE = float(np.log(0.5))
"""Logarithm of the probability from which ends are sure."""


class Grounder:
    """Follows commands with one model.

    Parameters
    ----------
    cost
        Scores factors.
    without
        Names of potentials that are switched off.
    rewriting
        False to leave clauses as they are (:mod:`g3.inference.problem.plain_clauses`).
    end_model
        Model of where all words say that loads end; None for the bundled one.

    Raises
    ------
    ModelError
        If there is no potential of such a name.
    """

    def __init__(
        self,
        cost: Cost,
        *,
        without: Iterable[str] = (),
        rewriting: bool = True,
        end_model: EndModel | None = None,
    ) -> None:
        self.cost = cost
        self.without = check_potentials(without)
        self.rewriting = rewriting
        self.end_model = end_model

    @classmethod
    def load(cls, model: GroundingModel | Path | str, *, without: Iterable[str] = ()) -> Grounder:
        """Return a grounder with the learned cost of a model.

        Parameters
        ----------
        model
            A model, its file, or its name (:func:`g3.inference.grounder.open_model`).
        without
            Names of potentials that are switched off.

        Raises
        ------
        ModelError
            If there is no such model, or no potential of such a name.
        """
        return cls(Scorer(open_model(model)), without=without)

    def __repr__(self) -> str:
        without = f", without={brief(sorted(self.without))}" if self.without else ""
        return f"Grounder({brief(self.cost)}{without})"

    def follow(
        self,
        command: str | Sequence[SDC] | Parse,
        context: Context | State,
        *,
        top: int = 1,
        width: int = WIDTH,
        answers: Mapping[int, str | Collection[str]] | None = None,
        explain: bool = False,
        least: float | None = None,
        parses: int = PARSES,
        insist: bool = False,
    ) -> Result:
        """Find what to do.

        Parameters
        ----------
        command
            Text, the top-level clauses of a command, or several trees with their probabilities.
        context
            The world, at the start of its log; or a state that an earlier plan led to.
        top
            Number of plans to return.
        width
            Width of the beam over plans.
        answers
            By node the id of the object that a clause means, ids of several, or the answer in words
            to the question about it (:meth:`answer`).
        explain
            True to give reasons.
        least
            A best plan that is less probable than this is no answer. None: one that fits nothing.
        parses
            Largest number of trees of a text that are tried where the best one is not sure. Plans
            of all trees that lead to the same count together. Answers are for the clauses of one
            tree: give that, or have one tried.
        insist
            True to plan with the things there are where a noun names none of them.
        """
        start = context if isinstance(context, State) else start_state(context)
        ids = {thing.id for thing in start.context.objects}
        replies = {n: a for n, a in (answers or {}).items() if isinstance(a, str) and a not in ids}
        if replies:
            options: dict[str, Any] = {
                "top": top,
                "width": width,
                "explain": explain,
                "least": least,
                "parses": parses,
                "insist": insist,
            }
            known = {node: a for node, a in (answers or {}).items() if node not in replies}
            asked = self.follow(command, context, answers=known, **options)
            if asked.question is None or asked.question.node not in replies:
                raise AnswerError("nothing is asked about this clause", fix="give question.node")
            reply = replies.pop(asked.question.node)
            return self.answer(asked, reply, answers=known | replies, **options)
        how: dict[str, Any] = {
            "start": start,
            "width": max(width, top),
            "answers": answers,
            "explain": explain,
            "insist": insist,
        }
        readings = self._readings(command, parses, **how)
        if readings[0][1].missing and not insist:
            return readings[0][1].refused()
        trees, choices, seen = self._compared(command, readings, max(top, LOOKED_AT), **how)
        if not choices:
            return trees[0].refused()
        order = best_plans([c.tree for c in choices], odds(seen), top)
        best = choices[order[0]]
        reading = trees[best.tree]
        plans = tuple(
            _plan(reading, choices[i].hypothesis, seen[i], self.cost if explain else None)
            for i in order
        )
        if least is None:
            is_likely = best.tree == PROPOSED or any(c.fit >= LEAST_FIT for c in choices)
        else:
            is_likely = plans[0].probability >= least * GUESSED_RIGHT ** len(_guessed(reading.tree))
        if not is_likely:
            return replace(reading, why="no plan is at all likely to be what was meant").refused()
        notes = (
            _guesses((*_guessed(reading.tree), *reading.untaught[0])),
            _undone(best.hypothesis),
            _nothing_about(left_aside(_end(best.hypothesis), reading.named, start)),
            "planned from all words together" if best.tree == PROPOSED else "",
        )
        note = "; ".join(filter(None, notes))
        acts = does_something(best.hypothesis)
        question = (
            question_about(reading.tree, best.hypothesis, start, reading.problem.answers)
            if acts
            else None
        )
        return Result(reading.tree.sdcs, plans, note, question, reading.missing, start)

    def compared(
        self, command: str | Parse, state: State, *, parses: int = PARSES
    ) -> tuple[list[Choice], FloatArray]:
        """Return the plans that are compared for a text, for learning to choose among them.

        Parameters
        ----------
        command
            A command, or its trees.
        state
            The state in which it is given.
        parses
            Largest number of its trees that are tried.

        Returns
        -------
        tuple of list of Choice and ndarray
            The n plans, and their evidence, shape (n, len(WEIGHTS)).
        """
        how: dict[str, Any] = {"start": state, "width": WIDTH, "answers": None}
        how |= {"explain": False, "insist": True}
        readings = self._readings(command, parses, **how)
        return self._compared(command, readings, LOOKED_AT, **how)[1:]

    def _readings(
        self, command: str | Sequence[SDC] | Parse, parses: int, **how: Any
    ) -> list[tuple[float, _Reading]]:
        """Return the trees of a command with their probabilities, the best first."""
        text = _text(command)
        trees = _trees(command, parses)
        return [(chance, self._read(sdcs, text=text, **how)) for chance, sdcs in trees]

    def _compared(
        self,
        command: str | Sequence[SDC] | Parse,
        readings: Sequence[tuple[float, _Reading]],
        most: int,
        **how: Any,
    ) -> tuple[list[_Reading], list[Choice], FloatArray]:
        """Return trees, the plans for them, and the plans' evidence, shape (n, len(WEIGHTS)).

        The last tree is the proposed one, if there is one.
        """
        from g3.inference.ends.end_model import (  # noqa: PLC0415 - as the parser
            UNTOLD,
            end_evidence,
            ends_of,
        )

        first = readings[0][1]
        start = first.problem.state
        places = {place.name for place in start.context.places if place.name}
        # The model of ends knows no places, and sees sides as they are at the start.
        told = self.rewriting and all(places.isdisjoint(own) for _, own in first.named)
        told = told and not any_seen_later(first.tree)
        ends = ends_of(_text(command), start, self.end_model) if told else None
        if ends is not None and asks_for_way(first.tree):
            ends = ends.of_loads()
        trees, proposed = self._searched(readings, ends, **how)
        found = [(chance, reading.found) for chance, reading in trees]
        choices = all_plans(found, most, waits=asks_to_wait(first.tree))
        plans = (plan for reading in proposed for plan in reading.found[:1])
        choices += [Choice(PROPOSED, plan, 0.0) for plan in plans]
        own = [*(reading for _, reading in trees), *proposed]
        rows = []
        for choice in choices:
            plan = choice.hypothesis
            end = end_evidence(ends, plan.actions, plan.state, start) if ends else UNTOLD
            rows.append(own[choice.tree].evidence(choice, end))
        return own, choices, np.array(rows)

    def _searched(
        self, readings: Sequence[tuple[float, _Reading]], ends: JointEnds | None, **how: Any
    ) -> tuple[list[tuple[float, _Reading]], list[_Reading]]:
        """Return trees with their plans, and the tree that asks for the most probable ends.

        Where these ends are sure, the first tree with a plan that leads there is the last one. A
        command that was given as its only tree, or with answers for one, asks for no ends.
        """
        from g3.inference.ends.end_model import ROBOT, plan_ends  # noqa: PLC0415 - as the parser
        from g3.inference.ends.proposal import (  # noqa: PLC0415 - as above
            likely_ends,
            proposal_of,
            sides_of,
        )

        start, width, spared = how["start"], how["width"], _ruled_out(readings)
        alone = bool(how["answers"]) or readings[0][0] == 1
        likely = {} if ends is None or alone else likely_ends(ends, start)

        def leads(plan: Hypothesis) -> bool:
            if ends is None or not likely:
                return False
            told = plan_ends(ends.rows, plan.actions, plan.state, start)
            return all(end in told.get(row, ()) for row, end in likely.items())

        wanted = {row: (end,) for row, end in likely.items()}
        sure = ends is not None and bool(likely) and ends.log_probability(wanted) > SURE
        found: list[tuple[float, _Reading]] = []
        for chance, reading in readings:
            found.append((chance, own := self._planned(reading, width, spared)))
            if sure and any(map(leads, own.found[:LOOKED_AT])):
                return found, []
        plans = [plan for _, reading in found for plan in reading.found]
        # Where each of several loads may be the one that is moved, each of them probably stays.
        of_robot = ROBOT in likely
        is_unsure = not sure and (of_robot or not plans)
        if not likely or is_unsure or (of_robot and not plans) or any(map(leads, plans)):
            return found, []
        words, missing = readings[0][1].words, readings[0][1].missing
        sides = {} if ends is None else sides_of(ends, likely)
        proposal = proposal_of(likely, start, metres_said(words), sides)
        if proposal is None:
            return found, []
        read = self._read(proposal.sdcs, **{**how, "answers": proposal.answers})
        own = self._planned(read, width, spared)
        kept = list(filter(leads, own.found))
        return found, [replace(own, words=words, missing=missing, found=kept)]

    def answer(self, result: Result, reply: str, **options: Any) -> Result:
        """Follow a command again, with an answer in words to the question about it.

        Parameters
        ----------
        result
            A result with a question.
        reply
            Words: "the left one", "both", "the one by the cone", "not that one", "neither", or the
            number of an option.
        options
            As in :meth:`follow`.

        Raises
        ------
        AnswerError
            If the answer picks out none of the options; it names them.
        ModelError
            If the result has no question.
        """
        question, start = result.question, result.start
        if question is None or start is None:
            raise ModelError("the result has no question", fix="answer a result that has one")
        clause = Tree(result.sdcs).nodes[question.node]
        ids = understood(question, clause, reply, partial(self._things, start=start))
        if not ids:
            return Result(result.sdcs, (), "none of these is meant", start=start)
        answers = {**options.pop("answers", {}), question.node: ids}
        return self.follow(result.sdcs, start, answers=answers, **options)

    def _things(
        self, sdcs: Sequence[SDC], node: int, allowed: tuple[str, ...], *, start: State
    ) -> list[Candidate]:
        """Ground an OBJECT in some of the things, the best first."""
        tree = Tree(tuple(sdcs))
        scene = scene_asked(tree, start)
        width = len(scene.groups)
        problem = GroundingProblem(
            start, scene, self.cost, answers={node: allowed}, width=width, disabled=self.without
        )
        return ground_thing(tree, node, problem)

    def _read(
        self,
        sdcs: tuple[SDC, ...],
        *,
        start: State,
        width: int,
        answers: Mapping[int, str | Collection[str]] | None,
        explain: bool,
        insist: bool,
        text: str = "",
    ) -> _Reading:
        words = text_words(text) or _words_of(sdcs)
        tree = Tree(plain(sdcs, Nouns(start), text) if self.rewriting else tuple(sdcs), text)
        problem = GroundingProblem(
            start,
            scene_asked(tree, start),
            self.cost,
            answers=one_each(answers or {}),
            explain=explain,
            disabled=self.without,
        )
        if not sdcs:
            return _Reading(tree, problem, words, why="there is no clause to follow in the text")
        why = refusal(CommandCase(tree, problem))
        if why:
            return _Reading(tree, problem, words, why=why)
        missing = absent_nouns(tree, start.context, self._lexicon)
        if missing and not insist:
            why = what_is_missing(missing, start.context)
            return _Reading(tree, problem, words, why=why, missing=missing)
        return _Reading(tree, prepared(tree, problem), words, missing=missing)

    def _planned(self, reading: _Reading, width: int, spared: Set[str]) -> _Reading:
        """Return a tree with its plans that handle no spared load."""
        tree, problem = reading.tree, reading.problem
        if reading.why:
            return reading
        found = search(tree, problem.state, problem, width=width)
        leaves = any(frame(tree, node).negated for node in asked(tree))
        if not (leaves or asks_to_wait(tree) or any(map(does_something, found[:1]))):
            return replace(reading, why="there is nothing in it that the robot could do")
        handled = ({action.object_id for action in plan.actions} for plan in found)
        kept = [plan for plan, own in zip(found, handled, strict=True) if spared.isdisjoint(own)]
        return replace(reading, found=kept)

    @property
    def _lexicon(self) -> Lexicon | None:
        chooser = self.cost.model.load_chooser_ if isinstance(self.cost, Scorer) else None
        return None if chooser is None else chooser.lexicon


@dataclass(frozen=True)
class _Reading:
    """A tree, all words of its text, and the plans for it, best first; why, if there are none."""

    tree: Tree
    problem: GroundingProblem
    words: tuple[str, ...]
    found: Sequence[Hypothesis] = ()
    why: str = ""
    missing: tuple[str, ...] = ()

    @cached_property
    def named(self) -> list[tuple[str, frozenset[str]]]:
        """The nouns with the things that they name, but for those that a clause rules out."""
        spared = {
            bare(word.text)
            for node in asked(self.tree)
            if negated(self.tree.nodes[node])
            for word in all_words(self.tree.nodes[node])
        }
        return [own for own in named_things(self.words, self.problem.state) if own[0] not in spared]

    @cached_property
    def untaught(self) -> tuple[tuple[str, ...], float]:
        """The words of relations that nobody has taught, and their share."""
        return untaught_words(self.tree, Nouns(self.problem.state))

    def evidence(self, choice: Choice, end_told: float) -> FloatArray:
        """Return the evidence of one of the plans, shape (len(WEIGHTS),)."""
        plan, start = choice.hypothesis, self.problem.state
        end = _end(plan)
        return evidence(
            choice.fit,
            aside=len(left_aside(end, self.named, start)),
            is_ambiguous=question_about(self.tree, plan, start, self.problem.answers) is not None,
            untaught=self.untaught[1],
            end=end_told,
            is_first=choice.is_first,
        )

    def refused(self) -> Result:
        start = self.problem.state
        return Result(self.tree.sdcs, (), self.why, missing=self.missing, start=start)


def _end(plan: Hypothesis) -> PlanEnd:
    return PlanEnd(plan.actions, plan.state)


def _ruled_out(readings: Sequence[tuple[float, _Reading]]) -> set[str]:
    """Return the loads that trees of at least half the probability rule out.

    A tree that loses a negation doesn't undo it.
    """
    against: dict[str, float] = defaultdict(float)
    for chance, reading in readings:
        for load in reading.problem.ruled_out:
            against[load] += chance
    half = sum(chance for chance, _ in readings) / 2
    return {load for load, chance in against.items() if chance >= half}


def _trees(command: str | Sequence[SDC] | Parse, count: int) -> list[tuple[float, tuple[SDC, ...]]]:
    """Return the trees of a command with their probabilities, the best first."""
    if isinstance(command, Sequence) and not isinstance(command, str):
        return [(1.0, tuple(command))]
    if isinstance(command, str):
        from g3.language.parsing.parser import parse_unsure  # noqa: PLC0415 - slow to import

        command = parse_unsure(command, n_best=count)
    return [(tree.probability, tree.sdcs) for tree in command.trees] or [(1.0, ())]


def _text(command: str | Sequence[SDC] | Parse) -> str:
    return command if isinstance(command, str) else getattr(command, "text", "")


def _guessed(tree: Tree) -> list[str]:
    """Return the verbs that aren't known."""
    frames = (frame(tree, node) for node in asked(tree))
    return [own.text for own in frames if own.guessed and own.text and not own.negated]


def _guesses(unknown: Sequence[str]) -> str:
    words = " and ".join(map(repr, dict.fromkeys(unknown)))
    return f"nobody has taught the robot what {words} means: this is a guess" if words else ""


def _undone(hypothesis: Hypothesis) -> str:
    left = ", ".join(hypothesis.undone)
    return f"there is no room for {left}, or no way to it" if left else ""


def _words_of(sdcs: Sequence[SDC]) -> tuple[str, ...]:
    return text_words(" ".join(word.text for sdc in sdcs for word in all_words(sdc)))


def _nothing_about(aside: Sequence[str]) -> str:
    return f"nothing is done about {' and '.join(map(repr, aside))}" if aside else ""


def _plan(reading: _Reading, hypothesis: Hypothesis, seen: FloatArray, cost: Cost | None) -> Plan:
    tree, problem = reading.tree, replace(reading.problem, referents=hypothesis.referents)
    why: dict[int, tuple[Action | Group | None, tuple[Reason, ...]]] = dict(hypothesis.reasons)
    if isinstance(cost, Scorer):
        why |= reasons_for_things(tree, hypothesis, problem, cost)
    groundings = []
    others = ground_others(tree, hypothesis.nodes, problem)
    for node, (group, score) in sorted({**hypothesis.nodes, **others}.items()):
        rival, reasons = why.get(node, (None, ()))
        given = float(np.exp(score))
        groundings.append(GroundedClause(node, tree.nodes[node], group, given, reasons, rival))
    return Plan(
        hypothesis.actions,
        plan_probability(seen) * GUESSED_RIGHT ** len(_guessed(tree)),
        hypothesis.score,
        tuple(groundings),
        hypothesis.state,
        tuple(seen.tolist()),
        clauses=hypothesis.clauses,
        start=problem.state,
    )
