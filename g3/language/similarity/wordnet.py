"""WordNet's nouns: its files, its morphology, and how similar two synsets are.

The files are those of Princeton WordNet 3.0 and its successors (``wndb(5WN)``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import InitVar, dataclass, field
from typing import Literal

from g3.short_repr import short_repr

Score = Literal["path", "wup", "lin"]

_SYNSET = re.compile(rb"^(\d{8}) [^|\n]*", re.MULTILINE)
_HYPERNYM = re.compile(rb" @i? (\d{8}) n ")
_COUNT = re.compile(rb"^([^%\s]+)%1:\S+ (\d+) (\d+)\s*$", re.MULTILINE)

_ENDINGS = (
    ("ses", "s"),
    ("ves", "f"),
    ("xes", "x"),
    ("zes", "z"),
    ("ches", "ch"),
    ("shes", "sh"),
    ("men", "man"),
    ("ies", "y"),
    ("s", ""),
)
"""Endings of plurals and what stands there in the singular (``morphy(7WN)``)."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class WordNet:
    """The nouns of WordNet.

    Parameters
    ----------
    senses
        The synsets of each lemma, the most frequent sense first. A synset's name is its
        offset in ``data.noun``; a lemma of several words has underscores.
    hypernyms
        What each synset is a kind or an instance of.
    exceptions
        Lemmas of irregular plurals.
    frequency
        How often each synset was seen in tagged text; never is left out.
    known_information
        The information content of all synsets, if it was computed before.
    """

    senses: Mapping[str, tuple[int, ...]]
    hypernyms: Mapping[int, tuple[int, ...]]
    exceptions: Mapping[str, tuple[str, ...]]
    frequency: Mapping[int, int]
    known_information: InitVar[Mapping[int, float] | None] = None
    _ancestors: dict[int, Mapping[int, int]] = field(default_factory=dict, init=False, repr=False)
    _depths: dict[int, int] = field(default_factory=dict, init=False, repr=False)
    _information: dict[int, float] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self, known_information: Mapping[int, float] | None) -> None:
        self._information.update(known_information or {})

    def lemmas(self, form: str) -> tuple[str, ...]:
        """The nouns that a form may be of: itself, irregular plurals, regular plurals."""
        form = form.lower().replace(" ", "_")
        found = [form, *self.exceptions.get(form, ())]
        stem, full = (form.removesuffix("ful"), "ful" if form.endswith("ful") else "")
        if len(stem) > 2 and not stem.endswith("ss"):
            found += [
                stem.removesuffix(plural) + singular + full
                for plural, singular in _ENDINGS
                if stem.endswith(plural)
            ]
        return tuple(dict.fromkeys(lemma for lemma in found if lemma in self.senses))

    def synsets(self, form: str) -> tuple[int, ...]:
        """All senses of all nouns that a form may be of."""
        return tuple(dict.fromkeys(s for lemma in self.lemmas(form) for s in self.senses[lemma]))

    def ancestors(self, synset: int) -> Mapping[int, int]:
        """The synset and all that it is a kind of, with the fewest steps up to each."""
        if synset not in self._ancestors:
            steps, level = {synset: 0}, {synset}
            while level:
                distance = 1 + max(steps.values())
                level = {h for s in level for h in self.hypernyms[s]} - steps.keys()
                steps.update(dict.fromkeys(level, distance))
            self._ancestors[synset] = steps
        return self._ancestors[synset]

    def depth(self, synset: int) -> int:
        """Synsets on the longest way from a root down to this one, both counted."""
        if synset not in self._depths:
            above = (self.depth(h) for h in self.hypernyms[synset])
            self._depths[synset] = 1 + max(above, default=0)
        return self._depths[synset]

    def information(self, synset: int) -> float:
        """Information content (Resnik, 1995): -ln of how often a noun names this or a kind of it.

        Every synset counts as seen once more than it was, so that none is impossible; what
        is a kind of two things counts for both.
        """
        if not self._information:
            seen = {s: 1.0 + self.frequency.get(s, 0) for s in self.hypernyms}
            for s in sorted(seen, key=self.depth, reverse=True):
                for h in self.hypernyms[s]:
                    seen[h] += seen[s]
            total = sum(seen[s] for s, above in self.hypernyms.items() if not above)
            self._information.update({s: -math.log(n / total) for s, n in seen.items()})
        return self._information[synset]

    def similarity(self, score: Score, a: int, b: int) -> float:
        """Similarity of two synsets, from 0 to 1.

        Parameters
        ----------
        score
            ``path``: 1 / (1 + steps between them). ``wup`` (Wu and Palmer, 1994):
            2d / (2d + steps) with the depth d of a shared ancestor. ``lin`` (Lin, 1998):
            the information of a shared ancestor by the mean of theirs. Of several shared
            ancestors the best counts.
        a, b
            Synsets.
        """
        if a == b:
            return 1.0
        above_a, above_b = self.ancestors(a), self.ancestors(b)
        steps = {s: above_a[s] + above_b[s] for s in above_a.keys() & above_b.keys()}
        if not steps:
            return 0.0
        if score == "path":
            return 1 / (1 + min(steps.values()))
        if score == "wup":
            return max(2 * d / (2 * d + n) for s, n in steps.items() for d in [self.depth(s)])
        both = self.information(a) + self.information(b)
        return 2 * max(map(self.information, steps)) / both if both else 0.0


def share_of_senses(net: WordNet, word: str, kinds: Sequence[str]) -> float:
    """Return the share of a noun's senses that are of some kinds; 0 for other words.

    Each sense counts once more than it was seen in tagged text.

    Parameters
    ----------
    net
        WordNet.
    word
        The noun, in any form.
    kinds
        Lemmas; each stands for the most general of its senses.
    """
    tops = {min(net.senses[kind], key=net.depth) for kind in kinds}
    weight = {s: 1 + net.frequency.get(s, 0) for s in net.synsets(word)}
    own = sum(n for s, n in weight.items() if tops & net.ancestors(s).keys())
    return own / sum(weight.values()) if weight else 0.0


def read_wordnet(index: bytes, data: bytes, exceptions: bytes, counts: bytes) -> WordNet:
    """Read WordNet's nouns.

    Parameters
    ----------
    index, data, exceptions, counts
        Contents of ``index.noun``, ``data.noun``, ``noun.exc`` and ``cntlist.rev``. The
        last says how often each sense occurs in the sense-tagged texts of WordNet; it may
        be empty.

    Raises
    ------
    ValueError
        If a file is not of this form.
    """
    hypernyms = {
        int(line[1]): tuple(map(int, _HYPERNYM.findall(line[0]))) for line in _SYNSET.finditer(data)
    }
    senses = dict(_senses(line) for line in index.splitlines() if not line.startswith(b"  "))
    named = {s for synsets in senses.values() for s in synsets}
    above = {h for synsets in hypernyms.values() for h in synsets}
    if not senses or not named | above <= hypernyms.keys():
        raise ValueError("index.noun and data.noun don't belong together")
    irregular = [line.split() for line in exceptions.decode().splitlines()]
    frequency: dict[int, int] = {}
    for lemma, number, count in _COUNT.findall(counts):
        for synset in senses.get(lemma.decode(), ())[int(number) - 1 : int(number)]:
            frequency[synset] = frequency.get(synset, 0) + int(count)
    return WordNet(senses, hypernyms, {form: tuple(of) for form, *of in irregular}, frequency)


def _senses(line: bytes) -> tuple[str, tuple[int, ...]]:
    """Read ``lemma pos n p [pointer...] n tagged offset...``."""
    lemma, _, count, *rest = line.split()
    return lemma.decode(), tuple(map(int, rest[len(rest) - int(count) :]))
