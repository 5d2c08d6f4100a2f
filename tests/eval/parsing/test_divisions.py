"""``ct eval --sdc`` on parts of a treebank, divided by scenario, person or world."""

import json

import pytest
from click.testing import CliRunner

pytest.importorskip("spacy")

from eval.cli.eval_commands import evaluate
from eval.parsing import sdc_scores
from g3.errors import CorpusError
from tests.small_treebank import write_treebank


@pytest.fixture
def treebank(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return write_treebank(tmp_path / "mine")


def scores(treebank, *options):
    done = CliRunner().invoke(evaluate, ["--sdc", "--corpus", str(treebank), *options, "--json"])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


@pytest.mark.parametrize("division", ["scenario", "person", "world"])
def test_each_part_is_tested_by_what_learned_from_the_others(treebank, division, monkeypatch):
    parts = []
    fit = sdc_scores.SDCParser.fit

    def counted(self, lessons, others=()):
        parts.append(len(lessons))
        return fit(self, lessons, others=others)

    monkeypatch.setattr(sdc_scores.SDCParser, "fit", counted)
    found = scores(treebank, "--cv", division)
    assert (found["commands"], found["cv"]) == (16, division)
    assert parts == {"scenario": [8, 8], "person": [12] * 4, "world": [8, 8]}[division]
    assert found["typed_f"] > 0.5


def test_people_must_be_known(treebank):
    (treebank / "people.jsonl").unlink()
    file = treebank / "trees.jsonl"
    file.write_text(file.read_text().replace('"person": "p1"', '"person": ""'))
    with pytest.raises(CorpusError, match="person of 4 commands is unknown"):
        scores(treebank, "--cv", "person")
