"""Words of relations that have neither a feature nor a rule: "parallel to the truck".

The search ignores such a word, and its plan looks as good as without it.
"""

from __future__ import annotations

from functools import cache, lru_cache

from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.negation import is_negation, negated
from g3.language.lexicon.field_words import bare, normalise
from g3.language.lexicon.tables import WORDS, rows
from g3.language.lexicon.verb_classes import word_class
from g3.sdc.clauses import Span

_OTHERS = ("class/", "cue/", "kind/", "kinds")
"""Rows whose words say nothing of relations, or are looked up by their class."""


def untaught_words(tree: Tree, nouns: Nouns) -> tuple[tuple[str, ...], float]:
    """Return the words of a command's relations that no list of the lexicon has, and their share.

    Of a clause's verb it is only the word before a place: "pull parallel to the truck". Nothing of
    clauses that forbid something, and no names of things.

    Parameters
    ----------
    tree
        The command.
    nouns
        What words may name in the world.

    Returns
    -------
    tuple of tuple of str and float
        The words, each once, and their share of all words of relations.
    """
    words: list[Span] = []
    for root in asked(tree):
        if not (tree.nodes[root].type == "EVENT" and negated(tree.nodes[root])):
            words += [word for node in tree.all_below(root) for word in _relating(tree, node)]
    words = [w for w in words if bare(w.text).isalpha()]
    untaught = [w for w in words if not _is_taught(bare(w.text))]
    untaught = [w for w in untaught if not (nouns.name_load((w,)) or nouns.name_other((w,)))]
    share = len(untaught) / max(len(words), 1)
    return tuple(dict.fromkeys(bare(w.text) for w in untaught)), share


def _relating(tree: Tree, node: int) -> tuple[Span, ...]:
    """Return the words of a clause that say where something is or goes."""
    sdc = tree.nodes[node]
    if sdc.type != "EVENT":
        return sdc.relation
    last = sdc.relation[tree.verbs[node].start + 1 :][-1:]
    goals = (p.relation[0] for p in sdc.children() if p.type in ("PATH", "PLACE") and p.relation)
    return last if any(0 <= goal.start - word.end <= 1 for word in last for goal in goals) else ()


@lru_cache(maxsize=65536)
def _is_taught(word: str) -> bool:
    is_known = not _lexicon().isdisjoint((word, normalise(word)))
    return is_known or bool(word_class(word)) or is_negation(word)


@cache
def _lexicon() -> set[str]:
    """Words of the tables, and their normal forms, but for classes and kinds of things."""
    shown = (row for row in rows().values() if not row.name.startswith(_OTHERS))
    words = {word for row in shown for word in (*row.words.split(), *row.values, *row.forms)}
    return words.union(WORDS["stressing"], map(normalise, words))
