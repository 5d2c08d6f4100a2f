"""Random groundings for the clauses of a command, and whether they happen to be right."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np

from corpus_tools.importers.authored.authored_clauses import (
    Clauses,
    Groundings,
    fits_words,
    leaf_words,
)
from corpus_tools.importers.authored.authored_files import Dataset, World
from corpus_tools.world.scenarios.scenario import ROBOT
from g3.groundings import Grounding, Path, PhysicalObject, Place
from g3.sdc.clauses import SDC, breadth_first, child_indices


def generator(seed: int, command_id: str) -> np.random.Generator:
    """Make the generator of one command. Its draws don't depend on other commands."""
    return np.random.default_rng([seed, zlib.crc32(command_id.encode())])


def random_groundings(
    clauses: Clauses, world: World, worlds: Sequence[World], rng: np.random.Generator
) -> tuple[Groundings, ...]:
    """Draw as many random groundings for each clause as it has right ones.

    As in section 4.1 of the paper, they come from all scenarios. An EVENT or a PATH gets the log of
    another scenario than `world`, where the command was given; it stays without a grounding if
    there is none. The groundings of a plural come from one scenario.
    """
    others = [w for w in worlds if w is not world]
    drawn: list[Groundings] = []
    for sdc, groundings in zip(breadth_first(clauses.sdcs), clauses.groundings, strict=True):
        if not groundings:
            drawn.append(())
        elif sdc.type in ("EVENT", "PATH"):
            logs = [w.context.agent for w in others]
            chosen = [logs[int(rng.integers(len(logs)))]] if logs else []
            drawn.append(tuple(a if sdc.type == "EVENT" else Path(a.trajectory) for a in chosen))
        else:
            source = worlds[int(rng.integers(len(worlds)))].context
            pool: Sequence[Grounding] = source.places if sdc.type == "PLACE" else source.objects
            picks = rng.choice(len(pool), size=min(len(groundings), len(pool)), replace=False)
            drawn.append(tuple(pool[i] for i in sorted(picks)))
    return tuple(drawn)


def relabel(
    clauses: Clauses, drawn: Sequence[Groundings], dataset: Dataset
) -> tuple[bool | None, ...]:
    """Label random groundings as right or wrong, like a person who sees only the clause.

    A leaf OBJECT is right if every object fits each of its words, as dataset.yaml lists
    them. With a word that isn't listed (an ordinal, a side) only its own objects are
    right. An OBJECT with a relation and a PLACE are right if they and their landmarks are
    the right ones. An EVENT or a PATH, whose log is another scenario's, is wrong. A
    clause without groundings has no label.
    """
    nodes = list(breadth_first(clauses.sdcs))
    children = child_indices(clauses.sdcs)
    same = [_same(random, right) for random, right in zip(drawn, clauses.groundings, strict=True)]
    labels: list[bool | None] = []
    for i, (sdc, random) in enumerate(zip(nodes, drawn, strict=True)):
        if not random:
            labels.append(None)
        elif sdc.type in ("EVENT", "PATH"):
            labels.append(False)
        elif sdc.type == "OBJECT" and sdc.is_leaf:
            labels.append(same[i] or _denotes(sdc, random, dataset))
        else:
            landmarks = (*children[i].get("l", ()), *children[i].get("l2", ()))
            labels.append(same[i] and all(same[k] for k in landmarks))
    return tuple(labels)


def _denotes(leaf: SDC, groundings: Groundings, dataset: Dataset) -> bool:
    words = leaf_words(leaf)
    if not all(word in dataset.words for word in words):
        return False
    named = {label for word in words for label in dataset.words[word]}
    return all(
        isinstance(item, PhysicalObject)
        and fits_words(item, words, dataset)
        and (item.id != ROBOT or not named.isdisjoint(item.labels))
        for item in groundings
    )


def _same(a: Groundings, b: Groundings) -> bool:
    return len(a) == len(b) and all(any(_alike(x, y) for y in b) for x in a)


def _alike(a: Grounding, b: Grounding) -> bool:
    """Check that two things look the same: their first position and their kind."""
    if isinstance(a, PhysicalObject) and isinstance(b, PhysicalObject):
        return a.labels == b.labels and a.prism == b.prism
    return isinstance(a, Place) and isinstance(b, Place) and a.prism == b.prism
