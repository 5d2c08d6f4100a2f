"""Evidence of all words of a text for a whole plan, which survives a wrong parse.

The clauses' factors see the words of a clause. Where the clauses are wrong, plans for several trees
of a text are compared, and these potentials say which of them does what the words speak of. Weights
are learned together, as a conditional logit over plans, from commands that imitate people
(``python -m benchmarks.plan_weights``).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State
from g3.groundings import FloatArray
from g3.inference.potentials.cases import PlanCase, PlanEnd
from g3.inference.potentials.plan_things import about, named_things, where_it_ends
from g3.inference.potentials.potential_registry import potential
from g3.language.discourse.negation import is_negation
from g3.language.lexicon.concepts import BESIDE, concepts
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_classes import word_class

ENDS = ("lifted", "on a thing", "on the ground", "not handled")
"""What may have become of a load."""
CUES = (
    *("placing", "taking", "carrying", "going"),
    *("last placing", "last taking", "last going"),
    *("on", "to", "floor", "beside", "up", "down", "forks", "any"),
)
"""What words may speak of: verbs by class, the last one's class, and where to from there on."""
THINGS = ("unnamed", "explained", "last", "named deck", "other deck")
"""What `of_things` measures."""

THING_WEIGHTS = {
    "unnamed": -0.64,
    "explained": 1.33,
    "last": 0.58,
    "named deck": 0.28,
    "other deck": -1.52,
}
END_WEIGHTS = {
    "placing": (-0.39, 0.28, 0.03, -0.36),
    "taking": (0.34, -0.01, -0.26, -0.06),
    "carrying": (-0.64, -0.21, -0.04, 0.68),
    "going": (0.04, 0.38, -0.32, 0.07),
    "last placing": (-0.86, 0.18, -0.01, 0.07),
    "last taking": (0.45, -0.55, -0.49, -0.23),
    "last going": (0.26, 0.23, -0.29, -0.01),
    "on": (-0.18, 0.26, -0.04, -0.17),
    "to": (-0.02, 0.07, 0.06, -0.11),
    "floor": (-0.81, -0.79, 0.27, -0.88),
    "beside": (0.18, 0.19, 0.08, -0.4),
    "up": (0.61, -0.91, -0.88, 0.25),
    "down": (-0.42, -0.8, 0.21, -0.33),
    "forks": (0.91, -1.3, -1.04, 0.62),
    "any": (0.46, 0.21, -0.29, -0.16),
}


@potential("plan-things", kind="plan", types=("EVENT",), weight=1.0)
def plan_things(case: PlanCase) -> FloatArray:
    """Things that words name are handled, or are where that comes from or ends; as learned."""
    result: FloatArray = of_things(case) @ np.array([THING_WEIGHTS[name] for name in THINGS])
    return result


@potential("plan-end", kind="plan", types=("EVENT",), weight=1.0)
def plan_end(case: PlanCase) -> FloatArray:
    """A load ends on the forks, on a thing or on the ground as verbs and "on" ask; as learned."""
    result: FloatArray = of_ends(case) @ np.array([END_WEIGHTS[cue] for cue in CUES]).reshape(-1)
    return result


def of_ends(case: PlanCase) -> FloatArray:
    """Return the cues, at the end that each plan has; (plans, `CUES` times `ENDS`)."""
    there = cues(case.words)
    seen = np.zeros((len(case.plans), len(CUES), len(ENDS)))
    for row, plan in zip(seen, case.plans, strict=True):
        row[:, _end(plan)] = [cue in there for cue in CUES]
    return seen.reshape(len(seen), -1)


def of_things(case: PlanCase) -> FloatArray:
    """Return how far plans are about things that words name, shape (plans, `THINGS`).

    How many named things have no part in the plan, and the share that has one; whether the last one
    is where it ends; whether that is a deck that is named, or one that isn't.
    """
    state = case.problem.state
    named = named_things(case.words, state)
    return np.array([_of_things(plan, named, state) for plan in case.plans])


def _of_things(
    plan: PlanEnd, named: Sequence[tuple[str, Collection[str]]], start: State
) -> tuple[float, float, float, float, float]:
    ends, own = where_it_ends(plan), about(plan, start)
    explained = [not own.isdisjoint(things) for _, things in named]
    under = carrier(plan.state, plan.put) if plan.put else None
    is_named = under is not None and any(under.id in things for _, things in named)
    return (
        float(len(named) - sum(explained)),
        float(np.mean(explained)) if named else 1.0,
        float(bool(named) and not ends.isdisjoint(named[-1][1])),
        float(is_named),
        float(under is not None and not is_named),
    )


def _end(plan: PlanEnd) -> int:
    if not plan.handled:
        return ENDS.index("not handled")
    if plan.put is None:
        return ENDS.index("lifted")
    on = carrier(plan.state, plan.put)
    return ENDS.index("on the ground" if on is None else "on a thing")


def cues(words: Sequence[str]) -> set[str]:
    """Return the cues in some words: verbs, and where to from the last verb on."""
    verbs = [next((c for c in word_class(w).split("+") if c in CUES), "") for w in words]
    verbs = ["" if is_negation(w) else verb for w, verb in zip(("", *words), verbs, strict=False)]
    last = max((i for i, verb in enumerate(verbs) if verb), default=0)
    found = {"any", *filter(None, verbs)}
    if any(verbs):
        found.add("last placing" if verbs[last] == "carrying" else f"last {verbs[last]}")
    stems = list(map(normalise, words[last:]))
    spoken = concepts(stems)
    found |= {"on", "to"} & spoken
    found |= {"beside"} if spoken & BESIDE else set()
    found |= {"floor"} if WORDS["floor"].intersection(stems) else set()
    found |= {"forks"} if WORDS["forks"].intersection(stems) else set()
    found |= {"up", "down"} & set(words[last:])
    found |= {"down"} if "off" in words[last:] else set()
    return found
