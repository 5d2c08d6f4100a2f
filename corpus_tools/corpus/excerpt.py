"""What a corpus holds on an id, as records: the same as in its files, for programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.encoding import encode
from corpus_tools.corpus.trajectory_arrays import Arrays


def excerpt(corpus: Corpus, name: str) -> Mapping[str, object]:
    """The command, annotation or context with an id, and what belongs to it.

    A command brings its annotations, and an annotation its command and its context.

    Returns
    -------
    mapping
        ``commands``, ``annotations`` and ``contexts``, each a list of records; and
        ``trajectories``, to which the records' numbers point: lists of ``t`` in s, ``xyz`` in m
        and ``yaw`` in rad.
    """
    annotations = tuple(a for a in corpus.annotations if name in (a.id, a.command.id))
    commands = {a.command.id: a.command for a in annotations}
    contexts = {a.context.id: a.context for a in annotations}
    commands |= {key: value for key, value in corpus.commands.items() if key == name}
    contexts |= {key: value for key, value in corpus.contexts.items() if key == name}
    tables = encode(
        replace(corpus, contexts=contexts, commands=commands, annotations=annotations, judgments=())
    )
    return {
        "commands": tables.commands,
        "annotations": tables.annotations,
        "contexts": tables.contexts,
        "trajectories": _trajectories(tables.trajectories),
    }


def _trajectories(arrays: Arrays) -> list[dict[str, object]]:
    offsets = arrays["offsets"].tolist()
    return [
        {name: arrays[name][start:end].tolist() for name in ("t", "xyz", "yaw")}
        for start, end in pairwise(offsets)
    ]
