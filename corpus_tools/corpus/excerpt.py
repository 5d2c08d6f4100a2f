"""What a corpus holds on an id, as records: the same as in its files, for programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from corpus_tools.corpus.corpus_entries import belongs_to
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.encoding import encode
from corpus_tools.corpus.trajectory_arrays import as_lists


def excerpt(corpus: Corpus, name: str) -> Mapping[str, object]:
    """The command, annotation or context with an id, and what belongs to it.

    A command brings its annotations and what was done, an annotation its command and its context.
    An outcome can be asked for too; it brings its context. ``commands``, ``annotations``,
    ``contexts`` and ``outcomes`` are lists of records; their numbers point to ``trajectories``:
    lists of ``t`` in s, ``xyz`` in m and ``yaw`` in rad.
    """
    annotations = tuple(a for a in corpus.annotations if name in (a.id, a.command.id))
    commands = {a.command.id: a.command for a in annotations}
    contexts = {a.context.id: a.context for a in annotations}
    outcomes = tuple(
        outcome
        for outcome in corpus.outcomes
        if name in (outcome.id, outcome.context)
        or (name in corpus.commands and belongs_to(outcome, corpus.commands[name]))
    )
    contexts |= {outcome.context: corpus.contexts[outcome.context] for outcome in outcomes}
    commands |= {key: value for key, value in corpus.commands.items() if key == name}
    contexts |= {key: value for key, value in corpus.contexts.items() if key == name}
    tables = encode(
        replace(
            corpus,
            contexts=contexts,
            commands=commands,
            annotations=annotations,
            judgments=(),
            outcomes=outcomes,
        )
    )
    return {
        "commands": tables.commands,
        "annotations": tables.annotations,
        "contexts": tables.contexts,
        "outcomes": tables.outcomes,
        "trajectories": list(as_lists(tables.trajectories)),
    }
