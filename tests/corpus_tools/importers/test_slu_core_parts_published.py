"""The other parts of the authors' release, where they are at hand. They may grow."""

from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.importers.slu_core.automatic_corpus import read_things
from corpus_tools.importers.slu_core.slu_corpus import find_automatic, find_relations, import_parts
from corpus_tools.importers.slu_core.slu_files import SCENARIOS

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def automatic(published_files):
    if not find_automatic(published_files).folders:
        pytest.skip(f"there are no random tasks in {published_files}")
    return import_parts(published_files, salt="salt", part="automatic")


def test_sizes_and_corners_are_those_of_the_contexts_of_the_paper(published, published_files):
    """The middles of 92 pallets and trailers in the contexts, from the corners in objects.xml.

    The two files have different origins, which the median takes away.
    """
    offsets = []
    for name, context in published[0].contexts.items():
        text = (published_files / SCENARIOS / name / "objects.xml").read_text()
        things = {item.id: item for item in read_things(text, lambda *_: None).objects}
        offsets += [
            item.prism.xy - things[item.id].prism.xy
            for item in context.objects
            if item.id in things
        ]
    assert len(offsets) >= 92
    middles = np.array([offset.mean(axis=0) for offset in offsets])
    away_m = np.linalg.norm(middles - np.median(middles, axis=0), axis=1)
    assert away_m.max() < 0.02
    # Corner by corner in the same order, and so of the same size.
    assert max(np.ptp(offset, axis=0).max() for offset in offsets) < 0.06


def test_random_tasks(automatic, published_files):
    corpus, report = automatic
    folders = find_automatic(published_files).folders
    assert len(corpus.contexts) == len(folders)
    assert {outcome.context for outcome in corpus.outcomes} == set(corpus.contexts)
    assert {command.scenario for command in corpus.commands.values()} <= set(corpus.contexts)
    assert report.skipped == ()
    for context in corpus.contexts.values():
        assert (context.agent_id, "heading") in context.assumed
    known = [outcome for outcome in corpus.outcomes if not outcome.unknown]
    assert {outcome.put for outcome in known} <= {"held", "on"}


def test_all_parts_in_one_corpus(published_files, published, tmp_path):
    corpus, report = import_parts(published_files, salt="salt", part="all")
    assert report.parts_taken == report.parts_there
    assert set(published[0].commands) <= set(corpus.commands)
    corpus.save(tmp_path / "all")
    assert validate(tmp_path / "all") == []
    if find_relations(published_files).names:
        labels = [a.correct[0] for a in corpus.annotations if a.id.startswith("spatial-relations")]
        assert labels.count(True) >= 330
        assert labels.count(False) >= 7059
