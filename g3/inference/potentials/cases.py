"""Cases that potentials score: one type for each of their kinds.

See :mod:`g3.inference.potentials.potential_registry`.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from g3.actions.grounding_candidates import ground
from g3.actions.robot_state import State
from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch, Role
from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray, Place
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.grounding_problem import Candidate, GroundingProblem, Group
from g3.inference.problem.phrases import factor_type, is_complement, named_places
from g3.sdc.clauses import SDC, SDCType
from g3.short_repr import short_repr

if TYPE_CHECKING:
    from g3.actions.action_kinds import Action
    from g3.inference.potentials.potential_registry import Kind
    from g3.inference.problem.grounding_problem import Arguments

T = TypeVar("T")


@short_repr
@dataclass(frozen=True, slots=True)
class CommandCase:
    """A command that the search is to begin with.

    Parameters
    ----------
    tree
        Its clauses.
    problem
        What it is to be grounded in.
    """

    kind: ClassVar[Kind] = "command"
    type: ClassVar[SDCType] = "EVENT"
    shape: ClassVar[tuple[int, ...]] = ()

    tree: Tree
    problem: GroundingProblem

    def has(self, role: Role) -> bool:
        """Nothing is grounded yet."""
        return True


@short_repr
@dataclass(frozen=True, slots=True)
class ReferentCase:
    """Candidates that a pronoun or "there" may stand for.

    Parameters
    ----------
    tree, node
        The clause.
    problem
        What it is grounded in.
    groups
        The candidates.
    is_theme
        Whether the clause is an EVENT that names no theme: "pick up".
    """

    kind: ClassVar[Kind] = "referent"

    tree: Tree
    node: int
    problem: GroundingProblem
    groups: Sequence[Group]
    is_theme: bool = False

    @property
    def type(self) -> SDCType:
        """Type of the clause's factor; whatever leads "there" names a PLACE."""
        is_thing = self.is_theme or self.tree.nodes[self.node].type == "OBJECT"
        return "OBJECT" if is_thing else "PLACE"

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of candidates."""
        return (len(self.groups),)

    def has(self, role: Role) -> bool:
        """There are figures alone."""
        return role == "figure"


@short_repr
@dataclass(frozen=True)
class CandidateCase:
    """Candidates that a clause names, or that another clause has as an argument.

    Parameters
    ----------
    tree, node
        The clause that the candidates are groundings of.
    problem
        What it is grounded in.
    groups
        The candidates.
    role
        What they are: the figure of their own clause, or the theme, the goal or a landmark of
        another one.
    within
        That other clause; the same for figures.
    """

    tree: Tree
    node: int
    problem: GroundingProblem
    groups: Sequence[Group]
    role: Role
    within: int

    @property
    def kind(self) -> Kind:
        """Kind of the candidates."""
        return "noun" if self.role == "figure" else "argument"

    @property
    def sdc(self) -> SDC:
        """The clause that the candidates are groundings of."""
        return self.tree.nodes[self.node]

    @property
    def clause(self) -> SDC:
        """The clause that has them in a role."""
        return self.tree.nodes[self.within]

    @property
    def type(self) -> SDCType:
        """Type of the factor of the clause that has them in a role."""
        return factor_type(self.clause)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of candidates."""
        return (len(self.groups),)

    def has(self, role: Role) -> bool:
        """Check that the candidates have a role."""
        return role == self.role

    @cached_property
    def called(self) -> frozenset[str]:
        """The places whose names the clause has."""
        return named_places(self.sdc, (p.name for p in self.problem.state.context.places))

    def each(self, test: Callable[[Group], bool]) -> BoolArray:
        """Apply a test to each candidate, shape (n,)."""
        return np.array([test(group) for group in self.groups], dtype=bool)


@short_repr
@dataclass(frozen=True)
class FactorCase:
    """Rows of an OBJECT's or a PLACE's factor: figures with their landmarks.

    Parameters
    ----------
    tree, node
        The clause.
    batch
        The rows; its first bodies are the context's objects.
    problem
        What it is grounded in.
    sizes
        How many things each row's figure is.
    """

    kind: ClassVar[Kind] = "factor"

    tree: Tree
    node: int
    batch: FactorBatch
    problem: GroundingProblem
    sizes: Sequence[int]

    @property
    def sdc(self) -> SDC:
        """The clause."""
        return self.tree.nodes[self.node]

    @property
    def type(self) -> SDCType:
        """Type of its factor: a PATH that tells where something is put has a PLACE's."""
        return "PLACE" if self.sdc.type == "PATH" else factor_type(self.sdc)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of rows."""
        return (len(self.batch),)

    def has(self, role: Role) -> BoolArray | bool:
        """Find the rows that have a grounding in a role."""
        return self.batch.once(("has", role), lambda batch: _filled(batch, role))

    @property
    def nothing(self) -> FloatArray:
        """Measures of rows that are as words say."""
        return np.zeros(len(self.batch))

    @property
    def is_part(self) -> bool:
        """Check that another clause says more of the same thing, without a landmark."""
        return self.node in self.tree.parts

    @cached_property
    def own_batch(self) -> FactorBatch:
        """The rows with the words that the clause adds: a landmark says more of a named thing."""
        if not self.sdc.landmark1 or is_complement(self.sdc):
            return self.batch
        unnamed = [{**words, "figure": ()} for words in self.batch.words]
        return replace(self.batch, words=unnamed)

    @property
    def load(self) -> int | None:
        """The body of what the clause moves; None for none."""
        if not self.problem.load:
            return None
        return [o.id for o in self.problem.state.context.objects].index(self.problem.load)

    @property
    def floor(self) -> float:
        """Height of the ground."""
        return ground(self.problem.state)

    @property
    def origin(self) -> FloatArray | None:
        """Position of the thing that goes to the place, shape (2,); None for the robot itself."""
        state, load = self.problem.state, self.problem.load
        return centre(state.thing(load).prism) if load else None


def _filled(batch: FactorBatch, role: Role) -> BoolArray | bool:
    has: BoolArray = batch.role(role) >= 0
    return has if has.any() != has.all() else bool(has.all())


@short_repr
@dataclass(frozen=True, slots=True)
class SpotCase:
    """Spots where something can be put.

    Parameters
    ----------
    problem
        What is put is its load; none where the robot goes there itself.
    spots
        The spots.
    """

    kind: ClassVar[Kind] = "spot"
    type: ClassVar[SDCType] = "PLACE"

    problem: GroundingProblem
    spots: Sequence[Place]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of spots."""
        return (len(self.spots),)

    def has(self, role: Role) -> bool:
        """There are spots, and maybe something that is put there."""
        return role == "figure" or (role == "theme" and self.problem.load is not None)


@short_repr
@dataclass(frozen=True)
class ActionCase:
    """Actions that the robot can do for a top-level clause.

    Parameters
    ----------
    tree, root
        The clause.
    state
        The state that the actions begin in.
    found
        What the clause may be about.
    actions
        The actions.
    problem
        What the command is grounded in.
    """

    kind: ClassVar[Kind] = "action"

    tree: Tree
    root: int
    state: State
    found: Arguments
    actions: Sequence[Action]
    problem: GroundingProblem
    _known: dict[Hashable, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def sdc(self) -> SDC:
        """The clause."""
        return self.tree.nodes[self.root]

    @property
    def type(self) -> SDCType:
        """Its type."""
        return self.sdc.type

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of actions."""
        return (len(self.actions),)

    def has(self, role: Role) -> bool:
        """Check that the clause has a candidate for a role, or actions imply one."""
        if role == "goal":
            return self.found.goals != (None,) or self.found.goal_path >= 0
        if role == "theme":
            return self.found.themes != (None,) or any(a.object_id for a in self.actions)
        return role == "figure"

    @property
    def path(self) -> SDC | None:
        """The PATH that tells where the clause leads; None where a PLACE does, or nothing."""
        return self.tree.nodes[self.found.goal_path] if self.found.goal_path >= 0 else None

    @cached_property
    def kinds(self) -> IntArray | Any:
        """Names of the actions' kinds, shape (n,)."""
        return np.array([a.kind.name for a in self.actions], dtype=str)

    def each(self, test: Callable[[Action], bool]) -> BoolArray:
        """Apply a test to each action, shape (n,)."""
        return np.array([test(action) for action in self.actions], dtype=bool)

    def once(self, compute: Callable[[ActionCase], T]) -> T:
        """Compute a function of the case once."""
        if compute not in self._known:
            self._known[compute] = compute(self)
        result: T = self._known[compute]
        return result


@short_repr
@dataclass(frozen=True, slots=True)
class PathCase:
    """Actions for a clause with a PATH, together with the PATH's landmarks.

    Parameters
    ----------
    tree, path
        The PATH.
    state
        The state that the actions begin in.
    actions, marks
        n actions, and m candidates of the landmark; None for none.
    problem
        What the command is grounded in.
    """

    kind: ClassVar[Kind] = "path"
    type: ClassVar[SDCType] = "PATH"

    tree: Tree
    path: int
    state: State
    actions: Sequence[Action]
    marks: Sequence[Candidate | None]
    problem: GroundingProblem

    @property
    def sdc(self) -> SDC:
        """The PATH."""
        return self.tree.nodes[self.path]

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of actions and of candidates."""
        return len(self.actions), len(self.marks)

    def has(self, role: Role) -> bool:
        """Check that there are actions and landmarks."""
        return role in ("figure", "landmark")
