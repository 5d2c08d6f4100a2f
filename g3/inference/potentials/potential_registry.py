"""The catalogue of potentials: every hand-written rule of inference is registered here.

With a few hundred commands much of what words mean can't be learned. So the search multiplies the
learned factors of the grounding graph by potentials: small functions that measure how far a
grounding is from what words say. A potential adds its weight times its measure to a score, which is
the logarithm of a probability. A weight of minus infinity makes it a hard constraint.

The search asks for all potentials of a kind at once and knows none by its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np

from g3.errors import ModelError
from g3.features.factor_batch import Role
from g3.features.feature_registry import FEATURES
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.registry import Registry, summary_of
from g3.sdc.clauses import SDCType
from g3.short_repr import short_repr

Kind = Literal["command", "referent", "noun", "argument", "factor", "spot", "action", "path"]
KINDS: dict[Kind, str] = {
    "command": "a command before the search begins: the reason to refuse it",
    "referent": 'what a pronoun or "there" stands for, candidate by candidate',
    "noun": "what a noun may name, candidate by candidate; the strongest of these counts",
    "argument": "what a clause may have as its theme, goal or landmark, candidate by candidate",
    "factor": "an OBJECT's or a PLACE's figure together with its landmark",
    "spot": "where something can be put, spot by spot",
    "action": "what the robot can do for a clause, action by action",
    "path": "actions together with the landmarks of a PATH",
}
"""What potentials score."""
HARD = -np.inf
"""The weight of a hard constraint."""


class Case(Protocol):
    """Candidates that potentials of one kind score: n, or n by m pairs."""

    @property
    def kind(self) -> Kind:
        """Kind of the candidates."""
        ...

    @property
    def type(self) -> SDCType:
        """Type of the clause's factor."""
        ...

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the scores."""
        ...

    @property
    def problem(self) -> GroundingProblem:
        """Problem that is grounded; it knows which potentials are switched off."""
        ...

    def has(self, role: Role) -> BoolArray | bool:
        """Find the candidates that have a grounding in a role."""
        ...


Measured = BoolArray | FloatArray | bool
"""How far each candidate is from what words say; False where they say nothing."""
Measure = Callable[[Any], Any]
"""From a case to how far each candidate is from what words say, an array of the case's shape; of
a command the reason why it is refused, empty for none."""


@short_repr
@dataclass(frozen=True, slots=True)
class Potential:
    """A rule of inference.

    Parameters
    ----------
    name
        Unique among potentials and feature sets; what ``--ablate`` takes.
    description
        One line, from the docstring.
    kind
        What it scores, one of :data:`KINDS`.
    types
        Types of the clauses that it reads.
    roles
        Groundings that must be present.
    weight
        What it adds to a score for each unit of its measure: the logarithm of a probability.
    measure
        How far candidates are from what words say, 0 for not at all.
    """

    name: str
    description: str
    kind: Kind
    types: tuple[SDCType, ...]
    roles: tuple[Role, ...]
    weight: float
    measure: Measure

    @property
    def is_hard(self) -> bool:
        """Check that what it measures is ruled out."""
        return self.weight == HARD


POTENTIALS: Registry[Potential] = Registry(
    "potential", "g3.potentials", error=ModelError, see="'ct features list' shows the potentials"
)
_BY_KIND: dict[Kind, list[Potential]] = {kind: [] for kind in get_args(Kind)}


def potential(
    name: str,
    *,
    kind: Kind,
    types: Iterable[SDCType],
    roles: Iterable[Role] = ("figure",),
    weight: float,
) -> Callable[[Measure], Measure]:
    """Register a function as a potential; the parameters are those of `Potential`."""

    def register(measure: Measure) -> Measure:
        if name in FEATURES:
            raise ValueError(f"the feature set {name!r} is registered already")
        about = summary_of(measure)
        added = Potential(name, about, kind, tuple(types), tuple(roles), weight, measure)
        POTENTIALS.add(added)
        _BY_KIND[kind] = sorted([*_BY_KIND[kind], added], key=lambda p: p.name)
        return measure

    return register


def potentials() -> tuple[Potential, ...]:
    """All registered potentials, by kind and name."""
    return tuple(p for own in _BY_KIND.values() for p in own)


@short_repr
@dataclass(frozen=True, slots=True)
class Ablation:
    """Parts left out: feature sets of the model, and potentials of the search."""

    sets: frozenset[str] = frozenset()
    potentials: frozenset[str] = frozenset()


def ablation(names: Iterable[str]) -> Ablation:
    """Tell names of feature sets from names of potentials.

    Raises
    ------
    ModelError
        If a name is neither.
    """
    wanted = frozenset(names)
    sets, more = frozenset(FEATURES), "'ct features list' shows them all"
    for name in sorted(wanted - sets - set(POTENTIALS)):
        known = [*sorted(sets), *sorted(POTENTIALS)]
        raise ModelError.unknown("feature set or potential", name, known, more=more)
    return Ablation(wanted & sets, wanted - sets)


def check_potentials(names: Iterable[str]) -> frozenset[str]:
    """Names of potentials that are to be switched off.

    Raises
    ------
    ModelError
        If one is not in the catalogue.
    """
    wanted = frozenset(names)
    POTENTIALS.check(wanted)
    return wanted


_HEARD: ContextVar[set[str] | None] = ContextVar("_HEARD", default=None)


@contextmanager
def heard() -> Iterator[set[str]]:
    """Note which potentials say something meanwhile.

    What comes of a command stays the same if a potential is switched off that says nothing of it.

    Yields
    ------
    set of str
        Their names, which come one by one.
    """
    names: set[str] = set()
    token = _HEARD.set(names)
    try:
        yield names
    finally:
        _HEARD.reset(token)


def _note(name: str) -> None:
    names = _HEARD.get()
    if names is not None:
        names.add(name)


def _measured(case: Case) -> Iterator[tuple[Potential, FloatArray]]:
    """The potentials that say something of a case, with what they measure."""
    kind, disabled = case.type, case.problem.disabled
    for own in _BY_KIND[case.kind]:
        if kind not in own.types or own.name in disabled:
            continue
        there = [case.has(role) for role in own.roles]
        measure = False if any(has is False for has in there) else own.measure(case)
        if measure is False:
            continue
        for has in there:
            if has is not True:
                measure = np.where(has, measure, 0.0)
        known = np.asarray(measure, dtype=float)
        if known.any():
            _note(own.name)
            yield own, known


def added_by(case: Case) -> dict[str, FloatArray]:
    """Return the scores that potentials add to a case, by name, but for those that add nothing."""
    found: dict[str, FloatArray] = {}
    for own, measure in _measured(case):
        # Nothing times a hard constraint's weight is nothing.
        weight = np.where(measure != 0, HARD, 0.0) if own.is_hard else own.weight * measure
        found[own.name] = np.broadcast_to(weight, case.shape)
    return found


def added(case: Case) -> FloatArray:
    """Return the sum that all potentials add to the scores of a case; its shape.

    What a noun doesn't name is ruled out once, whatever speaks against it: the strongest counts.
    """
    total = np.zeros(case.shape)
    for scores in added_by(case).values():
        total = np.minimum(total, scores) if case.kind == "noun" else total + scores
    return total


def allowed(case: Case) -> BoolArray:
    """Find the candidates that no hard constraint rules out; the case's shape."""
    result = np.ones(case.shape, dtype=bool)
    for own, measure in _measured(case):
        if own.is_hard:
            result &= measure == 0
    return result


def refusal(case: Case) -> str:
    """Why a command is refused; empty if it isn't."""
    for own in _BY_KIND[case.kind]:
        why = "" if own.name in case.problem.disabled else str(own.measure(case))
        if why:
            _note(own.name)
            return why
    return ""
