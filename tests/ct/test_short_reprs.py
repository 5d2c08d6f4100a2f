"""Whatever a notebook shows is short."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from itertools import islice

import numpy as np
import pytest

import ct
from corpus_tools.corpus.corpus_statistics import statistics
from corpus_tools.corpus.labelled_corpus import labelled_examples
from corpus_tools.importers.importer_registry import importers
from corpus_tools.world.scenarios.scenario_reading import (
    dataset_folder,
    read_scenario,
    scenario_files,
)
from g3.annotation import Command
from g3.features.feature_registry import catalogue, select
from g3.graph.grounding_graph import grounding_graph
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import potentials
from g3.inference.training import TOLERANCE, search_sets, training_data
from g3.learning.examples import to_batch
from g3.learning.factor_matrix import matrix_of_examples
from g3.learning.grounding_model import GroundingModel
from g3.sdc.sdc_notation import parse_brackets
from g3.short_repr import brief, short_repr
from tests.tiny_corpus import tiny_corpus

PACKAGES = ("ct", "g3", "corpus_tools", "eval", "annotation_app")
LONGEST = 2000
EACH = 5
"""So many objects of a type are looked at."""


def is_ours(cls: type) -> bool:
    return cls.__module__.partition(".")[0] in PACKAGES


def inside(thing: object) -> Iterable[object]:
    """What an object holds; of long ones some from all over."""
    if isinstance(thing, Mapping):
        return [*islice(thing.values(), 30)]
    if isinstance(thing, (list, tuple, set, frozenset)):
        items = list(thing)
        return [*items[:10], *items[:: max(1, len(items) // 20)]]
    names = [*getattr(thing, "__dict__", {}), *getattr(type(thing), "__slots__", ())]
    names += [f.name for f in fields(thing)] if is_dataclass(thing) else []  # type: ignore[arg-type]
    return [getattr(thing, name, None) for name in names if not name.startswith("__")]


def reachable(*roots: object) -> dict[type, list[object]]:
    """Objects of ours that others hold, some of each type."""
    found: dict[type, list[object]] = {}
    seen: set[int] = set()
    kept = []  # what is made on the way must not be forgotten, for its id is remembered
    queue = deque(roots)
    while queue:
        thing = queue.popleft()
        if id(thing) in seen or isinstance(thing, (str, bytes, int, float, type, np.ndarray)):
            continue
        seen.add(id(thing))
        kept.append(thing)
        if is_ours(type(thing)):
            known = found.setdefault(type(thing), [])
            if len(known) >= EACH:
                continue
            known.append(thing)
        elif not isinstance(thing, (Mapping, list, tuple, set, frozenset)):
            continue
        queue.extend(inside(thing))
    return found


def check(found: dict[type, list[object]]) -> None:
    for cls, things in found.items():
        for thing in things:
            text = repr(thing)
            assert len(text) <= LONGEST, f"{cls.__name__}: {text[:300]}"
            assert "\n" not in text, cls


@pytest.fixture(scope="module")
def corpus():
    return tiny_corpus()


@pytest.fixture(scope="module")
def grounder(corpus):
    positives = [a for a in corpus.annotations if a.source == "positive"]
    data = training_data(positives, search_sets())
    return Grounder.load(GroundingModel(tolerance=TOLERANCE).fit(data))


def test_all_that_is_made_of_a_corpus(corpus):
    items = labelled_examples(corpus)
    model = ct.train(corpus)
    graph = grounding_graph(corpus.annotations[0].sdcs)
    held = [
        corpus,
        list(corpus),
        items,
        to_batch(items),
        matrix_of_examples(items, select()),
        model,
        graph,
    ]
    found = reachable(*held, statistics(corpus), ct.evaluate(corpus, draws=20))
    assert {"Corpus", "Entry", "Example", "FactorBatch", "GroundingModel", "ResultTable", "SDC",
            "Statistics", "Trajectory"} <= {cls.__name__ for cls in found}  # fmt: skip
    check(found)


def test_all_that_comes_of_a_command(corpus, grounder):
    context = corpus.annotations[0].context
    sdcs = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))")
    result = grounder.follow(sdcs, context, top=3, explain=True)
    assert result.plan is not None
    found = reachable(grounder, result, ct.parse("Put the pallet on the truck", n_best=5))
    assert {"Action", "GroundedClause", "Grounder", "Parse", "Plan", "Result", "State"} <= {
        cls.__name__ for cls in found
    }
    check(found)


def test_all_that_is_registered_or_read():
    scenarios = [read_scenario(f) for f in scenario_files(dataset_folder("warehouse")).values()]
    found = reachable(catalogue(), potentials(), importers(), scenarios[:5])
    assert {"FeatureSet", "Importer", "Potential", "Scenario"} <= {cls.__name__ for cls in found}
    check(found)


def test_the_papers_corpus(published):
    corpus, report = published
    found = reachable(corpus, report, statistics(corpus), labelled_examples(corpus), list(corpus))
    check(found)
    assert len(corpus) == len(corpus.commands) > 200
    assert "annotations" in repr(corpus)


def test_a_long_text_and_many_items_are_cut():
    command = Command("id", "word " * 1000, "scenario")
    assert len(repr(command)) < 200
    assert brief(list(range(1000))) == "<1000 int>"
    assert brief(np.zeros((1000, 3))) == "<float64 (1000, 3)>"
    assert brief({"a": 1, "b": [1, 2]}) == "{'a': 1, 'b': <2 int>}"
    assert brief((1, None, "x")) == "(1, None, 'x')"
    assert len(brief(10**200)) <= 60


def test_defaults_are_left_out():
    @short_repr
    @dataclass
    class Thing:
        name: str
        parts: tuple[int, ...] = ()
        hidden: int = field(default=3, repr=False)

    assert repr(Thing("box")) == "Thing(name='box')"
    assert repr(Thing("box", (1, 2), 4)) == "Thing(name='box', parts=(1, 2))"
