"""From spaCy's dependencies (ClearNLP's labels) to Universal Dependencies, version 2.

Content words are heads in Universal Dependencies, where ClearNLP has function words: in "on the
truck" the noun is the head and "on" its ``case``; in "the truck is red" the adjective is the head
and "is" its ``cop``. The second conjunct and those after it depend on the first, and a conjunction
on the conjunct after it. What has a name of its own in both keeps its place. ``docs/language.md``
lists the labels. The guidelines are at https://universaldependencies.org/guidelines.html.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING

from g3.errors import ModelError
from g3.language.parsing.spacy_import import import_spacy
from g3.language.parsing.spacy_pipeline import Analysis, language_model

if TYPE_CHECKING:
    from spacy.tokens import Doc

RULES = ("attribute_ruler", "lemmatizer")
NOT_RULES = ("tok2vec", "tagger", "parser", "senter", "ner", "tokenizer")
"""What of a model isn't needed for its rules."""

RELATIONS: Mapping[str, str] = MappingProxyType(
    {
        "acomp": "xcomp",
        "agent": "advmod",
        "attr": "xcomp",
        "auxpass": "aux:pass",
        "complm": "mark",
        "csubjpass": "csubj:pass",
        "dative": "iobj",
        "dobj": "obj",
        "intj": "discourse",
        "neg": "advmod",
        "nsubjpass": "nsubj:pass",
        "oprd": "xcomp",
        "pcomp": "ccomp",
        "pobj": "obl",
        "poss": "nmod:poss",
        "preconj": "cc:preconj",
        "predet": "det:predet",
        "prep": "advmod",
        "prt": "compound:prt",
        "quantmod": "advmod",
        "relcl": "acl:relcl",
    }
)
"""ClearNLP's labels that only have another name, where no structure changes."""
SAME = frozenset(
    {
        "acl", "advcl", "advmod", "amod", "appos", "aux", "case", "cc", "ccomp", "compound", "conj",
        "cop", "csubj", "dep", "det", "expl", "mark", "nmod", "nsubj", "nummod", "obl", "obl:agent",
        "parataxis", "punct", "root", "xcomp",
    }
)  # fmt: skip
"""Labels of Universal Dependencies, given here or by ClearNLP with the same meaning."""
NOMINAL = frozenset({"NOUN", "PROPN", "PRON", "NUM", "SYM"})
_LIFTED = frozenset({"obl", "nmod", "obl:agent"})
_LEAVES = frozenset({"case", "mark", "cc", "punct", "aux", "aux:pass", "cop"})
"""What nothing depends on."""


@dataclass(frozen=True, slots=True)
class UniversalWord:
    """A word's columns in Universal Dependencies.

    Parameters
    ----------
    lemma
        Its dictionary form.
    upos
        Its part of speech.
    head
        Index of the word that it depends on; None for the root.
    relation
        How it depends on that.
    """

    lemma: str
    upos: str
    head: int | None
    relation: str


def universal_words(command: Analysis) -> tuple[UniversalWord, ...]:
    """A command's words in Universal Dependencies, as one tree.

    Several sentences are one tree: the roots of the others are ``parataxis`` of the first one's.

    Raises
    ------
    ModelError
        If the English model has no lemmas or no rules for parts of speech.
    """
    if not command.spans:
        return ()
    tags, lemmas, upos = _morphology(command)
    strings = language_model().vocab.strings
    labels = [strings[int(dep)].lower() for dep in command.dep]
    tree = _Tree(command.head.tolist(), labels, tags, lemmas, upos)
    tree.convert()
    return tuple(
        UniversalWord(lemma, part, None if head == i else head, relation)
        for i, (lemma, part, head, relation) in enumerate(
            zip(lemmas, tree.upos, tree.head, tree.relation, strict=True)
        )
    )


def _morphology(command: Analysis) -> tuple[list[str], list[str], list[str]]:
    """Tags, lemmas and universal parts of speech, by the model's own rules."""
    nlp = language_model()
    strings = nlp.vocab.strings
    tags = [strings[int(tag)] for tag in command.tag]
    doc: Doc = import_spacy().tokens.Doc(
        nlp.vocab,
        words=list(command.lower),
        tags=tags,
        deps=[strings[int(dep)] for dep in command.dep],
        heads=command.head.tolist(),
    )
    for pipe in _rules():
        doc = pipe(doc)
    # The rules are for words as in books; a word without a lemma is its own.
    return tags, [w.lemma_ or w.lower_ for w in doc], [w.pos_ or "X" for w in doc]


@lru_cache(maxsize=1)
def _rules() -> tuple[Callable[[Doc], Doc], ...]:
    """The model's rules for parts of speech and for lemmas."""
    nlp = language_model()
    # The vocabulary is shared, so that ids mean the same.
    rules = import_spacy().load(nlp.path, vocab=nlp.vocab, exclude=NOT_RULES)
    missing = [name for name in RULES if name not in rules.pipe_names]
    if missing:
        raise ModelError(
            f"the English model has no {missing[0]}, which Universal Dependencies need",
            fix="take a model with both, such as en_core_web_sm",
        )
    return tuple(rules.get_pipe(name) for name in RULES)


class _Tree:
    """A tree that is converted step by step; a root is its own head."""

    def __init__(
        self,
        head: list[int],
        relation: list[str],
        tags: Sequence[str],
        lemmas: Sequence[str],
        upos: list[str],
    ) -> None:
        self.head, self.relation, self.upos = head, relation, upos
        self.tags, self.lemmas = tags, lemmas

    def convert(self) -> None:
        """All steps, in their order: each counts on those before it."""
        self._lift_objects()
        self._lift_predicates()
        self._join_sentences()
        self._arrange_conjuncts()
        self._rename()
        self._free_leaves()
        self._attach_punctuation()

    def _children(self, word: int) -> list[int]:
        return [i for i, head in enumerate(self.head) if head == word and i != word]

    def _put_before(self, word: int, parent: int, relation: str) -> None:
        """Let a word take its parent's place; its siblings and the parent depend on it."""
        above = self.head[parent]
        for child in self._children(parent):
            self.head[child] = word
        self.head[word] = word if above == parent else above
        self.head[parent], self.relation[parent] = word, relation

    def _lift_objects(self) -> None:
        """Prepositions become ``case`` of what they are about, or ``mark`` of a clause."""
        for word in self._bottom_up():
            label = self.relation[word]
            is_preposition = label in ("prep", "agent") or self.upos[word] == "ADP"
            if not is_preposition or label == "prt":
                continue
            children = self._children(word)
            about = [c for c in children if self.relation[c] == "pobj"] or [
                c for c in children if self.relation[c] in _LIFTED
            ]
            clauses = [c for c in children if self.relation[c] == "pcomp"]
            if about:
                self._put_before(about[0], word, "case")
                self.relation[about[0]] = self._oblique(about[0], label)
            elif clauses:
                self._put_before(clauses[0], word, "mark")
                is_nominal = self.upos[self.head[clauses[0]]] in NOMINAL
                taken = {"prep": "acl" if is_nominal else "advcl", "agent": "advcl"}
                self.relation[clauses[0]] = taken.get(label, label)
            elif label in ("prep", "agent"):
                self.upos[word] = "ADV"

    def _oblique(self, word: int, label: str) -> str:
        """The relation of what a preposition is about, from the preposition's own."""
        if label == "agent":
            return "obl:agent"
        if label in ("prep", "dative"):
            return "nmod" if self.upos[self.head[word]] in NOMINAL else "obl"
        return label

    def _lift_predicates(self) -> None:
        """Let "is" be ``cop`` of what something is, or where it is."""
        for word in self._bottom_up():
            if self.lemmas[word] != "be" or self.relation[word] in ("aux", "auxpass", "cop"):
                continue
            children = self._children(word)
            labels = {self.relation[c] for c in children}
            predicates = [c for c in children if self.relation[c] in ("attr", "acomp")]
            if "expl" in labels:  # "there is a truck": the truck is what is there
                for child in predicates:
                    self.relation[child] = "nsubj"
                continue
            if labels & {"nsubj", "csubj"} and not predicates:
                predicates = [c for c in children if c > word and self.relation[c] == "obl"]
            if predicates:
                label = self.relation[word]
                self._put_before(predicates[0], word, "cop")
                self.relation[predicates[0]] = label
                self.upos[word] = "AUX"

    def _join_sentences(self) -> None:
        first, *others = [i for i, head in enumerate(self.head) if head == i]
        self.relation[first] = "root"
        for root in others:
            self.head[root], self.relation[root] = first, "parataxis"

    def _arrange_conjuncts(self) -> None:
        """Conjuncts depend on the first one, conjunctions and commas on the one after them."""
        conjuncts = [i for i, label in enumerate(self.relation) if label == "conj"]
        for word, label in enumerate(self.relation):
            if label == "cc" or (label == "punct" and self.tags[word] == ","):
                after = [c for c in conjuncts if c > word and self.head[c] == self.head[word]]
                if after and (label == "cc" or self.head[word] < word):
                    self.head[word] = after[0]
        for word in conjuncts:
            while self.relation[self.head[word]] == "conj":
                self.head[word] = self.head[self.head[word]]

    def _rename(self) -> None:
        for word, label in enumerate(self.relation):
            if label == "aux" and self.tags[word] == "TO":
                new = "mark"
            elif label == "npadvmod":
                is_nominal = self.upos[self.head[word]] in NOMINAL
                new = "nmod:unmarked" if is_nominal else "obl:unmarked"
            else:
                new = RELATIONS.get(label, label if label in SAME else "dep")
            if new == "nummod" and self.upos[word] != "NUM":
                new = "amod"  # "a few boxes"
            if new == "advmod" and self.upos[word] in ("ADP", "SCONJ"):
                self.upos[word] = "ADV"  # "back up", "where it was"
            self.relation[word] = new

    def _free_leaves(self) -> None:
        """Hang dependents of a function word from that word's head instead."""
        for word in range(len(self.head)):
            while self.relation[self.head[word]] in _LEAVES:
                self.head[word] = self.head[self.head[word]]

    def _attach_punctuation(self) -> None:
        """Punctuation depends on a word to which no other arc has to be crossed."""
        for word, label in enumerate(self.relation):
            if label != "punct" or self._is_clear(word, self.head[word]):
                continue
            beside = [w for w in (word - 1, word + 1) if 0 <= w < len(self.head)]
            above = [head for w in beside for head in self._path_up(w)]
            free = (h for h in above if self._is_clear(word, h) and self.relation[h] not in _LEAVES)
            self.head[word] = next(free, self.head[word])

    def _is_clear(self, word: int, head: int) -> bool:
        above = self._path_up(head)
        low, high = sorted((word, head))
        return (
            word not in above
            and all(head in self._path_up(w) for w in range(low + 1, high))
            and all(
                h in above
                for w, h in enumerate(self.head)
                if w != word and min(w, h) < word < max(w, h)
            )
        )

    def _path_up(self, word: int) -> list[int]:
        """A word and those above it, up to the root."""
        path = [word]
        while self.head[path[-1]] != path[-1]:
            path.append(self.head[path[-1]])
        return path

    def _bottom_up(self) -> Iterable[int]:
        """The words, those below others first."""
        depth = [0] * len(self.head)
        for word in range(len(self.head)):
            at = word
            while self.head[at] != at:
                at, depth[word] = self.head[at], depth[word] + 1
        return sorted(range(len(self.head)), key=lambda word: -depth[word])
