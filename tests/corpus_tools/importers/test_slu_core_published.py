"""The authors' release, where it is at hand: imported, replayed, and carried out anew."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np
import pytest

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_statistics import statistics
from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.world.physics.execute import execute
from corpus_tools.world.state.replay import NOTHING, carried, replay
from corpus_tools.world.state.robot_script import ScriptStep
from g3.groundings import PhysicalObject
from g3.sdc.clauses import SDC, breadth_first
from tests.corpus_tools.world.state.replayed import deviations
from tests.worlds import place

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def corpus(published):
    return published[0]


def objects(corpus, *sources):
    for annotation in corpus.annotations:
        if annotation.source in sources:
            for groundings in annotation.groundings:
                for grounding in groundings:
                    if isinstance(grounding, PhysicalObject):
                        yield annotation, grounding


def test_counts(published):
    corpus, report = published
    counted = statistics(corpus)
    assert counted.annotations == {"positive": 200, "random": 200, "easy": 336}
    assert len(counted.scenarios) == counted.videos == len(corpus.contexts) == 15
    assert (counted.commands, counted.commands_typed) == (200, 241)
    assert (counted.sdcs, counted.implicit) == (2205, 426)
    assert counted.sdcs_by_type == {"EVENT": 437, "OBJECT": 1507, "PLACE": 134, "PATH": 127}
    assert (counted.judgments_same, counted.judgments_different) == (1155, 1159)
    assert report.skipped == ()


def test_every_clause_has_its_entry(corpus):
    for annotation in corpus.annotations:
        clauses = sum(1 for _ in breadth_first(annotation.sdcs))
        assert len(annotation.groundings) == len(annotation.correct) == clauses


def test_the_implicit_robot_is_never_grounded(corpus):
    # Were the clauses read otherwise, their entries would shift and this would fail.
    for annotation in corpus.annotations:
        for sdc, groundings in zip(
            breadth_first(annotation.sdcs), annotation.groundings, strict=True
        ):
            if sdc == SDC("OBJECT"):
                assert groundings == ()


def test_it_is_sound_and_read_back(corpus, tmp_path):
    corpus.save(tmp_path / "corpus")
    assert validate(tmp_path / "corpus") == []
    assert Corpus.load(tmp_path / "corpus") == corpus


def test_no_worker_id_is_stored(published, published_files):
    corpus, report = published
    source = b"".join(path.read_bytes() for path in sorted(published_files.glob("*/*/*.yaml")))
    workers = set(re.findall(rb"workerId: *['\"]?([^\s,'\"}]+)", source))
    assert len(workers) > 50
    stored = b"".join([*corpus.files().values(), report.to_bytes()])
    assert not [worker for worker in workers if worker in stored]


# Nothing but the grounding may tell which file an example comes from.


def test_labels_do_not_tell_the_file(corpus):
    by_file = {
        source: {item.labels for _, item in objects(corpus, source)}
        for source in ("positive", "random", "easy")
    }
    assert by_file["positive"] == by_file["random"] == by_file["easy"]
    assert len(by_file["positive"]) == 4


def test_accessories_tell_no_more_than_the_object_itself(corpus):
    # Whatever the file, a pallet has the label exactly if it is a pallet of boxes.
    found = Counter(
        (annotation.source, "generator" in item.labels, "accessories" in item.labels)
        for annotation, item in objects(corpus, "positive", "random", "easy")
    )
    assert {key[1:] for key in found} == {(True, True), (False, False)}


def test_headings_do_not_tell_the_file(corpus):
    # In every file an object but the robot heads along its footprint's second edge.
    for annotation, item in objects(corpus, "positive", "random", "easy"):
        if item.id != annotation.context.agent_id:
            edge = item.prism.xy[2] - item.prism.xy[1]
            turn = item.trajectory.yaw[0] - np.arctan2(edge[1], edge[0])
            assert np.cos(turn) > 0.99


def test_positives_and_easy_negatives_are_objects_of_the_context(corpus):
    for annotation, item in objects(corpus, "positive", "easy"):
        assert any(item is other for other in annotation.context.objects)


def test_the_published_logs_are_replayed_truly(corpus):
    lifts = 0
    for context in corpus.contexts.values():
        assert max(deviations(context)) < 0.01
        recording = replay(context, 25.0)
        load = carried(recording)
        lifts += bool((load != NOTHING).any())
        assert np.abs(np.diff(recording.fork_height_m)).max() * 25 < 0.4
    assert lifts == 14  # all but go_to_receiving


@pytest.mark.parametrize("name", ["put_box_pallet_on_trailer", "go_to_receiving_loaded"])
def test_what_the_published_logs_move_can_be_moved(name, corpus):
    context = corpus.contexts[name]
    load = next(o for o in context.objects if len(o.trajectory) > 1 and o.id != context.agent_id)
    there = load.trajectory.xyz[-1]
    goal = place("goal", (there[0], there[1]), z=float(there[2]) - 0.4)
    steps = [ScriptStep("put_down", "goal")]
    if name != "go_to_receiving_loaded":
        steps.insert(0, ScriptStep("pick_up", load.id))
    done = execute(context, tuple(steps), places={"goal": goal})
    assert done.problems == ()
    assert done.outcomes[-1].error_m < 0.05
