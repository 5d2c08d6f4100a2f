"""A command's clauses as inference looks at them."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

from g3.inference.problem.phrases import (
    is_area,
    is_complement,
    is_measure,
    is_nounless,
    is_pronoun,
    names_forks,
    names_robot,
    names_thing,
    unstressed,
)
from g3.language.discourse.anaphora import Antecedent, anaphors
from g3.language.discourse.exclusions import exclusions
from g3.language.discourse.groups import noun_leaf
from g3.language.discourse.negation import negated
from g3.language.lexicon.concepts import Concept, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.language.lexicon.verb_chains import Verb, verb_of
from g3.language.parsing.words import cut
from g3.learning.examples import factor_words
from g3.sdc.clauses import SDC, Field, Span, all_words, breadth_first, child_indices
from g3.short_repr import short_repr

T = TypeVar("T")

_NO_KINDS = (
    WORDS["nounless"]
    | WORDS["collectives"]
    | WORDS["parts"]
    | WORDS["quantifiers"]
    | WORDS["everything"]
    | frozenset(COUNTS["counts"])
)
"""Words that don't say of which kind a thing is."""
_SCALES: tuple[tuple[Concept, Concept], ...] = (
    ("left", "right"),
    ("near", "far"),
    ("front", "back"),
    ("first", "last"),
)
"""By what things are told apart."""


@short_repr
@dataclass(frozen=True)
class Tree:
    """A command's clauses with what is looked up again and again.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    text
        Its text; empty where only the clauses are known.
    """

    sdcs: tuple[SDC, ...]
    text: str = ""
    _known: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def once(self, compute: Callable[..., T], *of: Hashable) -> T:
        """Compute a function of the command, or of something of it, once."""
        key = (compute, of)
        if key not in self._known:
            self._known[key] = compute(self, *of)
        result: T = self._known[key]
        return result

    @cached_property
    def nodes(self) -> list[SDC]:
        """All clauses, breadth first."""
        return list(breadth_first(self.sdcs))

    @cached_property
    def children(self) -> list[dict[Field, tuple[int, ...]]]:
        """The clauses in the fields of each."""
        return child_indices(self.sdcs)

    @cached_property
    def verbs(self) -> list[Verb]:
        """The verb of each clause that says what to do; of other clauses than EVENTs none."""
        relations = (sdc.relation if sdc.type == "EVENT" else () for sdc in self.nodes)
        return [verb_of(tuple(bare_words(words))) for words in relations]

    @cached_property
    def words(self) -> list[dict]:  # type: ignore[type-arg]
        """Words of each clause's factor; those of an area say where it is, as a PLACE's do.

        Of an EVENT's, without verbs that only lead on to another one.
        """
        spoken = [
            {f: unstressed(w) for f, w in self._with_noun(sdc, factor_words(own)).items()}
            for sdc, own in zip(self.nodes, map(_without_lead, self.nodes, self.verbs), strict=True)
        ]
        return [
            {**words, "figure": (), "name": ()} if is_area(sdc) else words
            for sdc, words in zip(self.nodes, spoken, strict=True)
        ]

    def _with_noun(self, sdc: SDC, words: dict) -> dict:  # type: ignore[type-arg]
        """Words of a clause with the noun that "the other" leaves out."""
        noun = self.left_out(sdc)
        return {
            **words,
            "figure": (*words["figure"], *field_words(noun)),
            "name": (*words["name"], *bare_words(noun)),
        }

    def left_out(self, sdc: SDC) -> tuple[Span, ...]:
        """The noun of the OBJECT before that "the other" or "the empty one" stands for, if any.

        That is the last one that has the same part in its clause, what is handled or where to, or
        the last that is told apart by the same: "load the far crate on the truck and lift the near
        one".
        """
        leaf = noun_leaf(sdc)
        if (
            sdc.type != "OBJECT"
            or not leaf.words
            or not (is_nounless(leaf) or _points_at(leaf, sdc))
        ):
            return ()
        if shared := self._noun_beside(sdc):
            return _kind(shared)
        before = [noun for noun in self.nouns if noun[-1].start < leaf.words[0].start]
        alike = [noun for noun in before if not _scales(noun).isdisjoint(_scales(leaf.words))]
        handled = leaf.words[0] in self._handled
        if handled:
            before = [noun for noun in before if noun[-1] not in self._led_to]
        same = [noun for noun in before if (noun[-1] in self._handled) == handled]
        last = max(alike or same or before, key=lambda noun: noun[-1].start, default=None)
        return _kind(last) if last else ()

    def _noun_beside(self, sdc: SDC) -> tuple[Span, ...]:
        """The noun that an OBJECT shares with the next of a list: "the left and right crates"."""
        lists = (own for node in self.nodes for own in (node.figure, node.landmark1) if sdc in own)
        after = next((own[own.index(sdc) + 1 :] for own in lists), ())
        ends = {noun_leaf(part).words[-1:] for part in after[:1]}
        return next((noun for noun in self.nouns if noun[-1:] in ends), ())

    @cached_property
    def left_alone(self) -> tuple[frozenset[int], tuple[SDC, ...]]:
        """OBJECTs that the command rules out, and others, which are in no clause.

        Where several begin alike, that is the outermost.
        """
        written = tuple(sorted({word for sdc in self.sdcs for word in all_words(sdc)}))
        others: list[SDC] = []
        excepting = [n for n in range(len(self.nodes)) if self.excepts(n)]
        nodes = {n for own in excepting for n in self.below(own, ("l", "l2"), "OBJECT")}
        begins = {
            n: all_words(sdc)[0].start
            for n, sdc in enumerate(self.nodes)
            if sdc.type == "OBJECT" and not WORDS["articles"].issuperset(_bare_words(sdc))
        }
        for noun in exclusions(cut(self.text).spans if self.text else written):
            inside = [n for n, start in begins.items() if noun[0].start <= start <= noun[-1].start]
            if inside:
                nodes.add(min(inside, key=lambda n: (begins[n], n)))
            else:
                others.append(SDC("OBJECT", words=noun))
        nodes -= {n for n in nodes if self._is_asked_for(n, excepting)}
        return frozenset(nodes) - self.put_elsewhere, tuple(others)

    def _is_asked_for(self, node: int, excepting: Sequence[int]) -> bool:
        """Check that what one clause excepts another one is about: "all but the crate here, …"."""
        if not any(node in self.all_below(n) for n in excepting):
            return False
        said = _bare_words(self.nodes[node])
        own = next(n for n in range(len(self.sdcs)) if node in self.all_below(n))
        return any(
            _bare_words(self.nodes[n]) == said
            for root in range(len(self.sdcs))
            if root != own and not negated(self.nodes[root])
            for n in self.below(root, ("f", "l"), "OBJECT")
        )

    @cached_property
    def put_elsewhere(self) -> frozenset[int]:
        """OBJECTs that are to be put elsewhere: "don't put the crate on the truck, put it here".

        What must not be loaded, or left somewhere, may be put elsewhere, too.
        """
        tops = range(len(self.sdcs))
        moved = {
            n
            for n in tops
            if self.verbs[n].classes & {"placing", "carrying"}
            or self.below(n, ("l", "l2"), "PLACE", "PATH")
        }
        forbidden = {c for n in moved if negated(self.nodes[n]) for c in self.all_below(n)}
        goals = {n for n in moved if self.below(n, ("l", "l2"), "PLACE", "PATH")}
        puts = {n for n in tops if "placing" in self.verbs[n].classes}
        led = {c for n in goals if negated(self.nodes[n]) for c in self.all_below(n)}
        first = self._spoken_again(puts) | self._spoken_again(goals).intersection(led)
        asked = {noun for n in moved if not negated(self.nodes[n]) for noun in self._about(n)}
        again = {n for n in forbidden for noun in (self._noun(n),) if noun and noun in asked}
        return frozenset(forbidden.intersection(first) | again)

    def _spoken_again(self, nodes: Iterable[int]) -> set[int]:
        """Return what pronouns stand for in those clauses that ask for something."""
        wanted = (c for n in nodes if not negated(self.nodes[n]) for c in self.all_below(n))
        return {self.antecedents[n][0].index for n in wanted if self.antecedents.get(n)}

    def _about(self, node: int) -> list[tuple[str, ...]]:
        """The OBJECTs that an EVENT is about, as words without articles."""
        return [self._noun(n) for n in self.below(node, ("f", "l"), "OBJECT")]

    def _noun(self, node: int) -> tuple[str, ...]:
        """The words of an OBJECT without articles; none of a pronoun."""
        sdc = self.nodes[node]
        if sdc.type != "OBJECT" or is_pronoun(sdc):
            return ()
        return tuple(word for word in _bare_words(sdc) if word not in WORDS["articles"])

    def excepts(self, node: int) -> bool:
        """Check if a clause excepts its landmark: "all but the red one", not "nothing but"."""
        sdc = self.nodes[node]
        figure = {word for part in sdc.figure for word in _bare_words(part)}
        relation = set(bare_words(sdc.relation))
        return bool(relation & WORDS["excepting"]) and figure.isdisjoint(
            WORDS["nothing"] | {"anything"}
        )

    @cached_property
    def antecedents(self) -> dict[int, tuple[Antecedent, ...]]:
        """Antecedents of OBJECTs that mean the same as another one: "it", "that crate"."""
        return {a.index: a.antecedents for a in anaphors(self.sdcs) if a.kind == "same"}

    @cached_property
    def _handled(self) -> frozenset[Span]:
        """Words of the OBJECTs that EVENTs are about, without those of their landmarks."""
        found = [n for n, sdc in enumerate(self.nodes) if sdc.type == "EVENT"]
        below = [c for n in found for c in self.below(n, ("f", "l", "l2"), "OBJECT")]
        below += [n for n in range(len(self.sdcs)) if self.nodes[n].type == "OBJECT"]
        for n in below:
            alike = is_complement(self.nodes[n]) or self.excepts(n)
            fields: tuple[Field, ...] = ("f", "l") if alike else ("f",)
            below += self.below(n, fields, "OBJECT")
        return frozenset(word for n in below for word in self.nodes[n].words)

    @cached_property
    def _led_to(self) -> frozenset[Span]:
        """Words of the places that something is brought to: they name no load."""
        events = [n for n, sdc in enumerate(self.nodes) if sdc.type == "EVENT"]
        moving = [n for n in events if self.below(n, ("f", "l"), "OBJECT")]
        goals = [c for n in moving for c in self.below(n, ("l", "l2"), "PLACE", "PATH")]
        below = {c for goal in goals for c in self.all_below(goal)}
        return frozenset(word for n in below for word in self.nodes[n].words)

    @cached_property
    def nouns(self) -> list[tuple[Span, ...]]:
        """The nouns that name things, with the words before them: "the left pallet of" tires."""
        before = {
            id(sdc.landmark1[0]): noun_leaf(sdc.figure[0]).words
            for sdc in self.nodes
            if sdc.type == "OBJECT" and is_complement(sdc) and sdc.figure and sdc.landmark1
        }
        leaves = [sdc for sdc in self.nodes if sdc.type == "OBJECT" and sdc.words]
        return [
            (*before.get(id(sdc), ()), *sdc.words)
            for sdc in leaves
            if bare(sdc.words[-1].text) not in _NO_KINDS
            and names_thing(sdc)
            and not (is_pronoun(sdc) or names_robot(sdc) or is_measure(sdc) or names_forks(sdc))
        ]

    @cached_property
    def parts(self) -> frozenset[int]:
        """OBJECTs of which another clause says more without a landmark: "the pallet" of tires."""
        return frozenset(
            child
            for node, sdc in enumerate(self.nodes)
            if sdc.type == "OBJECT" and (is_complement(sdc) or not sdc.landmark1)
            for child in (*self.children[node].get("f", ()), *self.children[node].get("l", ()))
        )

    def all_below(self, node: int) -> list[int]:
        """A clause and all clauses in it."""
        found = [node]
        for n in found:
            found.extend(c for group in self.children[n].values() for c in group)
        return found

    def below(self, node: int, fields: Sequence[Field], *types: str) -> list[int]:
        """Clauses of some types in some fields of another, in the order of the fields."""
        return [
            child
            for name in fields
            for child in self.children[node].get(name, ())
            if self.nodes[child].type in types and not self.nodes[child].is_implicit
        ]


def _without_lead(sdc: SDC, verb: Verb) -> SDC:
    return replace(sdc, relation=sdc.relation[verb.start :]) if verb.start else sdc


def _points_at(leaf: SDC, sdc: SDC) -> bool:
    """Check that an OBJECT says more of a demonstrative: "those on it"."""
    words = _bare_words(leaf)
    return len(words) == 1 and words[0] in WORDS["demonstratives"] and leaf != sdc


def _bare_words(sdc: SDC) -> list[str]:
    return bare_words(all_words(sdc))


def _kind(noun: tuple[Span, ...]) -> tuple[Span, ...]:
    """The words of a noun that say its kind: "box pallet" of "the left box pallet"."""
    start = len(noun) - 1
    while start and not _tells_apart(noun[start - 1]):
        start -= 1
    return noun[start:]


def _tells_apart(word: Span) -> bool:
    said = bare(word.text)
    return said in _NO_KINDS | WORDS["determiners"] or bool(concepts(field_words((word,))))


def _scales(noun: Sequence[Span]) -> set[tuple[Concept, Concept]]:
    """By what a noun with the words before it is told apart from others."""
    said = concepts(field_words(noun))
    return {scale for scale in _SCALES if said.intersection(scale)}
