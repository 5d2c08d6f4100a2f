"""Which loads the commands of a corpus were about, and the lexicon that is learned from them."""

import json

import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.load_choices import load_choices, load_choices_of
from corpus_tools.importers.authored.bundled import open_corpus
from tests.eval.yard import yards


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    return yards(tmp_path_factory.mktemp("yards"))


def right_of(choice):
    return [load.labels for load, right in zip(choice.loads, choice.right, strict=True) if right]


def test_outcomes_tell_what_was_meant(corpus):
    found = {" ".join(choice.words): choice for choice in load_choices(corpus)}
    assert "turn around and go" not in found  # nothing was picked up
    (held,) = right_of(found["lift the thing on the left"])
    assert "refrigerator" in held
    (ground,) = right_of(found["pick up the washer and put it down"])
    assert "washing" in ground
    assert len(found["pick up the pallet"].loads) == 1


def test_what_is_to_the_left_has_a_positive_bearing(corpus):
    (choice,) = (c for c in load_choices(corpus) if "thing" in c.words)
    fridge, washer = (load for load in choice.loads if "pallet" in load.labels)
    assert "refrigerator" in fridge.labels
    assert fridge.bearing > washer.bearing


def test_annotations_tell_it_where_there_are_no_outcomes(corpus):
    warehouse = open_corpus("warehouse")
    own = load_choices(warehouse)
    assert len(own) > 100
    for choice in own:
        (labels,) = right_of(choice)
        assert "trailer" not in labels
    assert {choice.corpus for choice in own} == {"warehouse"}
    # They are added to what was done, and alone teach the factors of clauses only.
    assert load_choices_of([warehouse]) == []
    assert len(load_choices_of([warehouse, corpus])) == len(own) + len(load_choices(corpus))


def test_a_lexicon_is_learned_and_shown(corpus, tmp_path, monkeypatch, capsys):
    corpus.save(tmp_path / "yards")
    monkeypatch.chdir(tmp_path)
    assert run(["similarity", "learn", "yards", "--out", "words.json", "--json"]) == 0
    learned = json.loads(capsys.readouterr().out)
    assert learned["commands"] == len(load_choices(corpus))
    assert run(["similarity", "show", "washer", "--lexicon", "words.json", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    (commands,) = {record["commands"] for record in shown}  # one, as probably as it was about that
    assert 0.5 < commands <= 1
    assert "washing" in shown[0]["name"]
    assert shown[0]["log_odds"] > 0 > shown[-1]["log_odds"]


def test_what_is_wrong_is_told(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["similarity", "show", "washer"]) == 2
    assert "--lexicon" in capsys.readouterr().err
    (tmp_path / "words.json").write_text("{}")
    assert run(["similarity", "show", "washer", "--lexicon", "words.json"]) == 2
    assert "no lexicon" in capsys.readouterr().err
    assert run(["similarity", "learn", "warehouse", "--out", "no/words.json"]) == 2
    assert "no such folder" in capsys.readouterr().err
