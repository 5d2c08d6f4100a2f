"""Problem of the first pass: its state, scene and cost, and its results."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from g3.actions.action_kinds import ActionKind, Amounts
from g3.actions.grounding_candidates import carrier, is_surface
from g3.actions.robot_state import State
from g3.groundings import FloatArray, Grounding, PhysicalObject
from g3.inference.problem.costs import Cost
from g3.inference.problem.packed_scene import Scene
from g3.short_repr import short_repr

Group = tuple[Grounding, ...]

WIDTH = 20
"""The paper's beam width."""
LANDMARKS = 6


def things_of(group: Group) -> list[PhysicalObject]:
    """The objects of a grounding."""
    return [g for g in group if isinstance(g, PhysicalObject)]


def group_key(group: Group) -> tuple[object, ...]:
    """Return a key that tells groups apart."""
    return tuple(g.id if isinstance(g, PhysicalObject) else id(g) for g in group)


def one_each(answers: Mapping[int, str | Collection[str]]) -> dict[int, tuple[str, ...]]:
    """Return answers with the id of one object, or those of several, as ids of several."""
    return {node: (ids,) if isinstance(ids, str) else tuple(ids) for node, ids in answers.items()}


@short_repr
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


@short_repr
@dataclass(frozen=True)
class GroundingProblem:
    """State, scene and cost in which the first pass grounds clauses.

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
        What pronouns may stand for by :mod:`g3.language.discourse.anaphora`, with probabilities:
        the groundings of OBJECTs of earlier clauses, by the pronoun's clause.
    goals
        What earlier clauses lead to, the last one last: "there" is one of them.
    spoken
        Ids of what earlier clauses mean.
    load
        Id of what the clause moves: it goes where there is room for it, and is no landmark of that.
    held
        Id of what is on the forks when the clause begins.
    width
        Width of the beams.
    landmarks
        Of a clause's beam, how many candidates are tried as landmarks.
    told_side
        "left" or "right" if the robot has been told to go there, for what it comes to.
    answers
        Ids of the objects that a clause is known to mean one or several of, by node.
    explain
        Whether reasons are asked for.
    disabled
        Names of potentials that are switched off.
    later
        The state in which the clause begins, where a side is told as it is then, or something is
        put where earlier clauses lead.
    only
        Id of the load that a clause about several is carried out for; empty for others.
    raised
        True if loads go on something, False if they go on the ground, as the request's first load
        did; None if either is possible.
    ruled_out
        Ids of what must not be handled.
    leaves
        What is known of OBJECTs without others below, by node: the log-probabilities of their
        factors with each of the scene's groups.
    """

    state: State
    scene: Scene
    cost: Cost
    referents: tuple[Group, ...] = ()
    antecedents: Mapping[int, tuple[tuple[Group, float], ...]] = field(default_factory=dict)
    goals: tuple[Group, ...] = ()
    spoken: frozenset[str] = frozenset()
    load: str | None = None
    held: str | None = None
    width: int = WIDTH
    landmarks: int = LANDMARKS
    told_side: str = ""
    answers: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    explain: bool = False
    disabled: frozenset[str] = frozenset()
    later: State | None = None
    only: str = ""
    raised: bool | None = None
    ruled_out: frozenset[str] = frozenset()
    leaves: Mapping[int, FloatArray] = field(default_factory=dict)

    @cached_property
    def carriers(self) -> Mapping[str, str]:
        """By id, the id of what an object stands on, if that isn't the ground."""
        things = (o for o in self.state.context.objects if o.id != self.state.context.agent_id)
        under = {thing.id: carrier(self.state, thing.id) for thing in things}
        return {upper: lower.id for upper, lower in under.items() if lower is not None}

    @cached_property
    def surfaces(self) -> frozenset[str]:
        """Ids of what a load can be put on."""
        return frozenset(o.id for o in self.state.context.objects if is_surface(o))


@short_repr
@dataclass(frozen=True, slots=True)
class Arguments:
    """Candidates of what a top-level clause is about.

    Parameters
    ----------
    themes, goals
        Candidates of its theme and of its goal; None alone where it has none.
    goal_path
        The PATH whose landmark the goal is, -1 if there is none.
    paths
        Other PATHs with the candidates of their landmarks.
    problem, toward
        What themes and landmarks are grounded in, and what goals are.
    asked
        Kinds of actions that its words ask for; none where they leave that open.
    amounts
        How far, or how much, they say.
    """

    themes: tuple[Candidate | None, ...]
    goals: tuple[Candidate | None, ...]
    goal_path: int
    paths: Mapping[int, tuple[Candidate | None, ...]]
    problem: GroundingProblem | None = None
    toward: GroundingProblem | None = None
    asked: frozenset[ActionKind] = frozenset()
    amounts: Amounts = field(default_factory=Amounts)
