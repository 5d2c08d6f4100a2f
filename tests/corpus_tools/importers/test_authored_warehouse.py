"""The bundled dataset: what a reader may take for granted about it."""

from __future__ import annotations

import itertools
import re
import shutil

import numpy as np
import pytest

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_tables import encode
from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.importers.authored.authored_corpus import import_authored, leaf_words
from corpus_tools.importers.authored.bundled import bundled
from corpus_tools.world.scenarios.scenario_reading import read_layouts
from corpus_tools.world.state.thing_kinds import KINDS
from g3.groundings import Path, PhysicalObject, Place
from g3.sdc.clauses import all_words, breadth_first
from tests.corpus_tools.importers.authored_logs import write_logs

SOURCE = bundled()["warehouse"]
UNCLAIMED = {"and", "but", "can", "could", "now", "ok", "please", "so", "then", "would", "you"}
"""Words that are in no clause: conjunctions and politeness."""


@pytest.fixture(scope="module")
def warehouse():
    corpus, _ = import_authored(SOURCE)
    return corpus


@pytest.fixture(scope="module")
def positives(warehouse):
    return [a for a in warehouse.annotations if a.source == "positive"]


def clauses(annotation):
    return zip(
        breadth_first(annotation.sdcs), annotation.groundings, annotation.correct, strict=True
    )


def test_is_as_large_as_promised(warehouse):
    assert len(warehouse.contexts) >= 8
    assert len(warehouse.commands) >= 80
    per_scenario = [c.scenario for c in warehouse.commands.values()]
    assert min(map(per_scenario.count, warehouse.contexts)) >= 8


def test_no_text_is_given_twice(warehouse):
    texts = [c.text.lower().strip(" .") for c in warehouse.commands.values()]
    assert len(set(texts)) == len(texts)


def test_clauses_hold_every_word_once_but_for_conjunctions_and_politeness(positives):
    for annotation in positives:
        text = annotation.command.text
        spans = [span for sdc in annotation.sdcs for span in all_words(sdc)]
        claimed = [i for span in spans for i in range(span.start, span.end)]
        assert len(claimed) == len(set(claimed)), text
        words = {m.start(): m.group().lower() for m in re.finditer(r"[\w']+", text)}
        assert {span.start for span in spans} <= words.keys(), text
        left = {word for start, word in words.items() if start not in claimed}
        assert left <= UNCLAIMED, text


def test_groundings_have_the_kinds_of_their_clauses(positives):
    kinds = {
        "EVENT": PhysicalObject,
        "OBJECT": (PhysicalObject, Place),
        "PLACE": Place,
        "PATH": Path,
    }
    for annotation in positives:
        for sdc, groundings, correct in clauses(annotation):
            assert all(isinstance(g, kinds[sdc.type]) for g in groundings)
            assert correct is (True if groundings else None)
            if sdc.type == "EVENT":
                assert all(g is annotation.context.agent for g in groundings)


def test_labels_are_the_same_in_positives_and_negatives(warehouse):
    def label_sets(source):
        return {
            g.labels
            for a in warehouse.annotations
            if a.source == source
            for groundings in a.groundings
            for g in groundings
            if isinstance(g, PhysicalObject)
        }

    kinds = {kind.labels for kind in KINDS.values()}
    assert label_sets("positive") | label_sets("random") <= kinds


def test_negatives_have_the_trees_and_plural_counts_of_the_positives(warehouse, positives):
    negatives = {a.command.id: a for a in warehouse.annotations if a.source == "random"}
    assert len(negatives) == len(positives)
    for positive in positives:
        negative = negatives[positive.command.id]
        assert negative.sdcs == positive.sdcs
        assert [*map(len, negative.groundings)] == [*map(len, positive.groundings)]


def test_negatives_are_relabelled_where_they_fit_the_words(warehouse):
    labels = {}
    for annotation in warehouse.annotations:
        if annotation.source == "random":
            for sdc, groundings, correct in clauses(annotation):
                if sdc.is_leaf and sdc.type == "OBJECT" and len(groundings) == 1:
                    thing = groundings[0]
                    labels.setdefault((" ".join(leaf_words(sdc)), thing.labels), set()).add(correct)
                if sdc.type in ("EVENT", "PATH"):
                    assert not correct
    assert labels["the pallet", ("tire", "pallet")] == {True}
    assert labels["the boxes", ("tire", "pallet")] == {False}
    assert labels["the trailer", ("truck",)] == {False}


def test_random_logs_are_of_other_scenarios(warehouse):
    logs = [c.agent.trajectory for c in warehouse.contexts.values()]
    for annotation in warehouse.annotations:
        if annotation.source == "random":
            for sdc, groundings, _ in clauses(annotation):
                if sdc.type in ("EVENT", "PATH") and groundings:
                    assert groundings[0].trajectory in logs
                    assert groundings[0].trajectory != annotation.context.agent.trajectory


def test_logs_of_scenarios_do_not_overlap_in_time(warehouse):
    times = sorted(
        (c.agent.trajectory.t[0], c.agent.trajectory.t[-1]) for c in warehouse.contexts.values()
    )
    assert all(end < start for (_, end), (start, _) in itertools.pairwise(times))


def test_layouts_have_other_origins_and_orientations():
    layouts = read_layouts(SOURCE).values()
    assert len({layout.at for layout in layouts}) == len(layouts)
    assert len({layout.yaw_deg for layout in layouts}) == len(layouts)


def test_the_way_to_receiving_leads_between_the_tires(warehouse):
    context = warehouse.contexts["dock_go_to_receiving"]
    tires = [o.trajectory.xyz[0, :2] for o in context.objects if "tire" in o.labels]
    middle = np.mean(tires, axis=0)
    way = context.agent.trajectory.xyz[:, :2]
    assert np.linalg.norm(way - middle, axis=1).min() < 1.0


def test_importing_twice_gives_the_same_bytes(warehouse):
    again, _ = import_authored(SOURCE)
    assert again.files() == warehouse.files()
    assert "2011" in warehouse.source


def test_is_written_and_read_back(warehouse, tmp_path):
    warehouse.save(tmp_path / "corpus")
    assert validate(tmp_path / "corpus") == []
    assert (
        encode(Corpus.load(tmp_path / "corpus").content).counts()
        == encode(warehouse.content).counts()
    )


def test_the_example_in_the_documentation_can_be_imported(tmp_path):
    documentation = SOURCE.parent.parent / "docs" / "authored-corpora.md"
    example = documentation.read_text().partition("```yaml\n")[2].partition("```")[0]
    shutil.copytree(SOURCE / "layouts", tmp_path / "layouts")
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "example.yaml").write_text(example)
    write_logs(tmp_path)
    (tmp_path / "dataset.yaml").write_bytes((SOURCE / "dataset.yaml").read_bytes())
    corpus, _ = import_authored(tmp_path)
    assert len(corpus.annotations) == 2


def test_the_dataset_card_tells_the_sizes(warehouse, positives):
    card = (SOURCE / "README.md").read_text()
    examples = [
        correct
        for annotation in warehouse.annotations
        for _, groundings, correct in clauses(annotation)
        if groundings
    ]
    nodes = [sdc for annotation in positives for sdc in breadth_first(annotation.sdcs)]
    types = [sdc.type for sdc in nodes]
    for size in (
        f"{len(warehouse.commands)} commands",
        f"{len(warehouse.contexts)} scenarios",
        f"{len(nodes)} clauses",
        f"{types.count('EVENT')} EVENT",
        f"{types.count('OBJECT')} OBJECT",
        f"({sum(sdc.is_implicit for sdc in nodes)} of them",
        f"{types.count('PLACE')} PLACE",
        f"{types.count('PATH')} PATH",
        f"{len(examples)} examples",
        f"{examples.count(True)} of them right",
    ):
        assert size in card
