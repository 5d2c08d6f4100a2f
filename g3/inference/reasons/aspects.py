"""Reasons in plain words: features of the same sort are put together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from g3.features.feature_registry import FeatureSet, catalogue
from g3.inference.potentials.potential_registry import Potential, potentials
from g3.inference.problem.scoring import Reason
from g3.inference.reasons.explanation import BESIDES
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import SDC, all_words
from g3.short_repr import short_repr

TELLING = float(np.log(1.1))
"""Smallest change of the odds that is reported."""
MOST = 4
"""Largest number of aspects that are reported."""
MOST_WORDS = 2
MANY = 100
"""Larger odds are reported as more than this."""

_CALLED = "what it is called"
_NUMBER = "how many things it is"
_WHERE = "where it stands, seen from the robot and among things alike"
_TO_LANDMARK = "how it lies to the other thing named"
_DRIVING = "how the robot drives, and where it ends"
_WAY = "which way the robot goes or turns"
_LOAD = "what happens to the load"

ASPECTS = {
    "arguments": _NUMBER,
    "labels": _CALLED,
    "mixed-labels": _CALLED,
    "word-domain": _CALLED,
    "word-form": _CALLED,
    "word-tags": _CALLED,
    "word-vectors": _CALLED,
    "word-wordnet": _CALLED,
    "bearing": _WHERE,
    "named-order": _WHERE,
    "named-position": _WHERE,
    "ranks": _WHERE,
    "avs-intrinsic": _TO_LANDMARK,
    "avs-log": _TO_LANDMARK,
    "avs-speaker": _TO_LANDMARK,
    "avs-start": _TO_LANDMARK,
    "between": _TO_LANDMARK,
    "named-relation": _TO_LANDMARK,
    "prism-pair": _TO_LANDMARK,
    "landmark-labels": "what the other thing named is",
    "scene": "whether the place is free, and what is near it",
    "event-frames": _DRIVING,
    "event-goal": _DRIVING,
    "event-prisms": _DRIVING,
    "path-frames": _DRIVING,
    "path-landmark": _DRIVING,
    "path-prisms": _DRIVING,
    "event-theme": "how the robot drives to the load",
    "theme-goal": "where the load ends",
    "theme-labels": "what the load is",
    "theme-motion": _LOAD,
    "named-shape": _WAY,
    "shape": _WAY,
    "besides/goal": "how well the goal itself fits its words",
}
"""Aspects that feature sets report."""


@short_repr
@dataclass(frozen=True, slots=True)
class Aspect:
    """Evidence for or against a grounding, summed over all features of a sort.

    Parameters
    ----------
    about
        Its subject, for people to read.
    words
        The clause's words that count most in it.
    weight
        Its addition to the log-odds.
    """

    about: str
    words: tuple[str, ...]
    weight: float

    @property
    def text(self) -> str:
        """The aspect in words.

        >>> Aspect("what it is called", ("tires",), 1.5).text
        '4.5 times likelier for what it is called ("tires")'
        """
        way = "likelier" if self.weight > 0 else "less likely"
        quoted = ", ".join(f'"{word}"' for word in self.words)
        by = f" ({quoted})" if quoted else ""
        odds = float(np.exp(abs(self.weight)))
        times = f"{odds:.1f}" if odds <= MANY else f"over {MANY}"
        return f"{times} times {way} for {self.about}{by}"


def aspects(reasons: Sequence[Reason], sdc: SDC) -> list[Aspect]:
    """Sum the reasons for a clause's grounding up, the weightiest first."""
    spoken = {normalise(span.text): span.text.strip(".,;:!") for span in all_words(sdc)}
    spoken = {word: text for word, text in spoken.items() if word not in WORDS["articles"]}
    parts: dict[str, list[Reason]] = {}
    for reason in reasons:
        parts.setdefault(_about(reason), []).append(reason)
    found = []
    for about, own in parts.items():
        weight = sum(r.weight for r in own)
        by_word: Counter[str] = Counter()
        for reason in own:
            for word in reason.word.partition(":")[2].split("_"):
                by_word[word] += reason.weight if weight > 0 else -reason.weight  # type: ignore[assignment]
        telling = [w for w, part in by_word.most_common() if part > TELLING and w in spoken]
        found.append(Aspect(about, tuple(spoken[w] for w in telling[:MOST_WORDS]), weight))
    told = [aspect for aspect in found if abs(aspect.weight) > TELLING]
    return sorted(told, key=lambda aspect: -abs(aspect.weight))[:MOST]


def _about(reason: Reason) -> str:
    """Return the subject of a reason; feature sets of other distributions describe themselves."""
    known = ASPECTS.get(reason.feature.partition("/")[0]) or ASPECTS.get(reason.feature)
    if known:
        return known
    rule = reason.feature.removeprefix(BESIDES)
    if rule != reason.feature:
        return f"the rule {rule}: {_descriptions(potentials()).get(rule, '')}".rstrip(": ")
    name = reason.feature.partition("/")[0]
    return _descriptions(catalogue()).get(name, name)


def _descriptions(registered: Sequence[FeatureSet] | Sequence[Potential]) -> dict[str, str]:
    """Return the descriptions of registered members, as parts of sentences."""
    told = {own.name: own.description.rstrip(".") for own in registered}
    return {name: text[:1].lower() + text[1:] for name, text in told.items()}
