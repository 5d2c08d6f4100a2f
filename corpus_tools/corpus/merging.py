"""Several corpora as one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import chain

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.encoding import make_corpus
from g3.errors import CorpusError


def merged(name: str, corpora: Sequence[Corpus]) -> Corpus:
    """Put all that corpora hold into one, in their order; CorpusError if two have the same id."""
    for what, ids in {
        "context": chain.from_iterable(c.contexts for c in corpora),
        "command": chain.from_iterable(c.commands for c in corpora),
        "annotation": (a.id for c in corpora for a in c.annotations),
        "judgment": (j.id for c in corpora for j in c.judgments),
        "outcome": (o.id for c in corpora for o in c.outcomes),
    }.items():
        twice = next((name for name, count in Counter(ids).items() if count > 1), "")
        if twice:
            raise CorpusError(
                f"two of the corpora have the {what} {twice!r}",
                where=name,
                fix="rename it in one of them",
            )
    return make_corpus(
        name,
        contexts=chain.from_iterable(c.contexts.values() for c in corpora),
        commands=chain.from_iterable(c.commands.values() for c in corpora),
        annotations=chain.from_iterable(c.annotations for c in corpora),
        judgments=chain.from_iterable(c.judgments for c in corpora),
        outcomes=chain.from_iterable(c.outcomes for c in corpora),
        source="; ".join(dict.fromkeys(c.source for c in corpora)),
        licence="; ".join(dict.fromkeys(c.licence for c in corpora)),
    )
