"""Phrases of paths on made-up examples: what is read, and what is refused or left out."""

from __future__ import annotations

import bz2
from pathlib import Path

import pytest
from click.testing import CliRunner

from corpus_tools.cli.import_commands import import_
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.importers.slu_core.slu_corpus import import_parts
from g3.errors import FormatError
from g3.groundings import Path as PathGrounding
from tests.corpus_tools.importers import random_tasks
from tests.corpus_tools.importers.path_phrases import EXAMPLES, put_phrases


@pytest.fixture
def source(tmp_path) -> Path:
    return put_phrases(tmp_path / "clone" / "data" / "spatial_relations").parent


def read(path, **options):
    return import_parts(path, salt="salt", part="spatial-relations", **options)


def test_what_is_read(source):
    corpus, report = read(source)
    assert {c.id: (c.text, c.scenario) for c in corpus.commands.values()} == {
        "spatial-relations/past-the-chair": ("past the chair.", "spatial-relations/chair"),
        "spatial-relations/past-the-desk": ("past the desk.", "spatial-relations/desk"),
        "spatial-relations/to-the-desk": ("to the desk.", "spatial-relations/desk"),
    }
    told = {a.id: (a.source, a.correct, a.context.id) for a in corpus.annotations}
    assert told == {
        "spatial-relations/past-the-desk/0": ("positive", (True, True), "spatial-relations/desk/1"),
        "spatial-relations/past-the-desk/1": ("random", (False, True), "spatial-relations/desk/2"),
        "spatial-relations/to-the-desk/2": ("random", (False, True), "spatial-relations/desk/1"),
        "spatial-relations/past-the-chair/3": (
            "random",
            (False, True),
            "spatial-relations/chair/1",
        ),
    }
    first = corpus.annotations[0]
    path, landmark = (group[0] for group in first.groundings)
    assert isinstance(path, PathGrounding)
    # The stamps count the poses; they become seconds.
    assert path.trajectory.t == pytest.approx([0, 1, 2])
    assert path.trajectory is first.context.agent.trajectory
    assert landmark in first.context.objects
    assert (landmark.id, landmark.labels) == ("desk-1", ("desk",))
    assert report.counts["examples that are right"] == 1
    assert report.counts["examples that are wrong"] == 3


def test_a_landmark_of_which_only_a_point_is_known_gets_a_size(source):
    corpus, report = read(source)
    context = corpus.annotations[3].context
    assert context.assumed == (("chair-1", "size"),)
    assert context.objects[0].prism.xy.min(axis=0) == pytest.approx([4.9501, -0.0499])
    assert context.objects[0].prism.xy.max(axis=0) == pytest.approx([5.0501, 0.0501])
    (note,) = report.notes
    assert note.records == ("chair (1)",)
    assert corpus.annotations[0].context.assumed == ()


@pytest.mark.parametrize("up", [0, 1, 2])
def test_it_is_found_in_a_clone_and_by_itself(source, up):
    path = [source, *source.parents][up]
    assert read(path)[0] == read(source)[0]


def test_a_plain_file_is_the_same(source):
    (file,) = source.iterdir()
    expected, _ = read(source)
    file.with_suffix("").write_bytes(bz2.decompress(file.read_bytes()))
    file.unlink()
    assert read(source)[0] == expected


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("r: past", "r: beside", "occurs 0 times"),
        ("[true, true]", "[true]", "groundingIsCorrect: 1 entries for 2 clauses"),
        ("timestamps: ['0', '1', '2']", "timestamps: ['0']", "shape"),
        ("tag: [desk]", "tag: 7", "this is not an object"),
        ("  command: [", "  orders: [", "this is not an example"),
    ],
)
def test_what_cannot_be_read(source, tmp_path, old, new, what):
    (file,) = source.iterdir()
    assert old in EXAMPLES
    file.write_bytes(bz2.compress(EXAMPLES.replace(old, new, 1).encode()))
    with pytest.raises(FormatError, match=r"record 1 \(sr_past_0\)") as caught:
        read(source)
    assert what in str(caught.value)
    assert "--keep-going" in caught.value.fix
    out = tmp_path / "out"
    command = ["slu-core", str(source), "--part", "spatial-relations", "--out", str(out)]
    result = CliRunner().invoke(import_, [*command, "--keep-going"])
    assert result.exit_code == 0, result.exception
    assert "skipped: spatialRelations.someone.yaml.bz2: record 1" in result.output
    assert len(Corpus.load(out).annotations) == 3


def test_all_that_is_there_is_one_sound_corpus(source, tmp_path):
    group = source.parent / "corpusCommandsForVideoSmallFilesOnly" / "forklift.automatic.v1"
    random_tasks.put_world(group)
    out = tmp_path / "out"
    command = ["slu-core", str(source.parents[1]), "--part", "all", "--out", str(out)]
    result = CliRunner().invoke(import_, command)
    assert result.exit_code == 0, result.exception
    parts = "automatic, spatial-relations"
    assert f"imported {parts}; there are {parts}" in result.output
    assert validate(out) == []
    both = Corpus.load(out)
    assert (len(both.commands), len(both.outcomes), len(both.annotations)) == (5, 1, 4)
