"""What an outsider mistypes is answered at once, with what to type instead."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

import ct
from corpus_tools.runtime.parallel import Workers
from g3.errors import CorpusError, ModelError
from g3.language.parsing.trees import Parse, Tree
from g3.learning.grounding_model import GroundingModel
from g3.sdc.sdc_notation import parse_brackets
from tests.tiny_corpus import tiny_corpus


@pytest.fixture(scope="module")
def corpus():
    return tiny_corpus()


def never(*_args: object, **_options: object) -> None:
    raise AssertionError("work began before the arguments were looked at")


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"to": "folow"}, r"to can't be 'folow' \(did you mean 'follow'\?"),
        ({"negatives": "foo"}, r"negatives can't be 'foo' \(give one of random, hard\)"),
        ({"l2": -1}, r"l2 can't be -1 \(give a number above 0\)"),
        ({"l2": "a"}, "l2 can't be 'a'"),
        ({"ablate": ["label"]}, "there is no feature set 'label'"),
    ],
)
def test_training(corpus, given, says):
    with pytest.raises(CorpusError, match=says):
        ct.train(corpus, **given)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"table": "1"}, r"table can't be '1' \(did you mean 1\? give one of 1, 2, 3\)"),
        ({"draws": -3}, "draws can't be -3"),
        ({"draws": 0}, "draws can't be 0"),
        ({"jobs": 0}, "jobs can't be 0"),
        ({"l2": float("nan")}, "l2 can't be nan"),
        ({"ablat": "x"}, r"Table 1: there is no option 'ablat' \(did you mean 'ablate'\?"),
        ({"table": 2, "ablate": "x"}, "Table 2: there is no option 'ablate'"),
    ],
)
def test_evaluating(corpus, given, says, monkeypatch):
    monkeypatch.setattr("ct.measurement._folder_of", never)
    with pytest.raises(CorpusError, match=says):
        ct.evaluate(corpus, **given)


@pytest.mark.parametrize("row", ["grounder", "parser", "judge"])
def test_a_row_that_is_not_there(corpus, row):
    with pytest.raises(CorpusError, match=f"there is no {row} 'mother'"):
        ct.evaluate(corpus, table=3, **{row: "mother"})


def test_nobody_works():
    with pytest.raises(CorpusError, match="0 jobs"):
        Workers(0)


def test_names_may_have_commas_as_on_the_command_line(corpus):
    by_text = ct.train(corpus, ablate="labels, shape")
    assert [s.name for s in by_text.features] == [
        s.name for s in ct.train(corpus, ablate=["labels", "shape"]).features
    ]
    assert "labels" not in {s.name for s in by_text.features}


@pytest.mark.parametrize("given", [5, None, ["a", "b"]])
def test_what_is_no_corpus_and_no_command(given, corpus):
    with pytest.raises(CorpusError, match=f"corpus can't be of the type {type(given).__name__}"):
        ct.load(given)
    with pytest.raises(CorpusError, match="give its text, or an entry of a corpus"):
        ct.parse([given] if isinstance(given, list) else given)
    with pytest.raises(CorpusError, match=r"(command|a clause) can't be of the type"):
        ct.follow([[given]] if isinstance(given, list) else given, corpus[0].context)


def test_what_is_no_world():
    with pytest.raises(CorpusError, match="where can't be of the type int"):
        ct.follow("Go", 5, model=ct.train(tiny_corpus()))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"camera": "above"}, "camera can't be 'above'"),
        ({"quality": "drft"}, "did you mean 'draft'"),
        ({"size": (3, 3)}, "even numbers"),
        ({"size": (1280,)}, "even numbers"),
        ({"fps": 0}, "fps can't be 0"),
    ],
)
def test_filming(given, says, tmp_path):
    pytest.importorskip("mujoco", reason="the extra `render` is not installed")
    with pytest.raises(CorpusError, match=says):
        ct.render("dock_go_to_receiving", tmp_path, **given)
    with pytest.raises(CorpusError, match="what can't be of the type"):
        ct.render(7, tmp_path)  # type: ignore[arg-type]


def test_importing_and_exporting(corpus, tmp_path):
    with pytest.raises(CorpusError, match=r"there is no option 'prt' \(did you mean 'part'"):
        ct.import_corpus("slu-core", tmp_path, prt="automatic")
    with pytest.raises(CorpusError, match="part can't be 'half'"):
        ct.import_corpus("slu-core", tmp_path, part="half")
    with pytest.raises(CorpusError, match=r"to can't be 'csvv' \(did you mean 'csv'"):
        ct.export(corpus, tmp_path / "x", to="csvv")


def test_a_corpus_knows_its_ids(corpus):
    assert corpus[0].id in corpus
    assert corpus[0] in corpus
    assert "nobody said this" not in corpus
    with pytest.raises(KeyError, match=f"ids are like '{corpus[0].id}'"):
        corpus["nobody said this"]
    with pytest.raises(KeyError, match=f"ids are like '{corpus[-1].id}'"):
        corpus[f"{corpus[-1].id}s"]


def test_parts_of_a_corpus_are_asked_for_by_ids_and_functions(corpus):
    assert list(corpus.select(corpus[0].id)) == [corpus[0]]
    with pytest.raises(CorpusError, match="there is no command 'nope'"):
        corpus.select("nope")
    with pytest.raises(CorpusError, match="give a function of an entry"):
        corpus.filter("truck")
    with pytest.raises(CorpusError, match="did you mean 'world'"):
        corpus.split("worlds")


@pytest.mark.parametrize("given", ["Go", ["Go"], None, 5, np.zeros((2, 3))])
def test_a_model_learns_from_examples_only(given):
    with pytest.raises(ModelError, match="make them of a corpus: examples"):
        GroundingModel().fit(given)
    with pytest.raises(ModelError, match="make them of a corpus: examples"):
        ct.train(tiny_corpus()).predict_proba(given)


def test_copies_are_equal(corpus):
    for thing in (corpus, corpus[0], corpus[0].context, corpus[0].annotations[0]):
        assert pickle.loads(pickle.dumps(thing)) == thing
        assert copy.deepcopy(thing) == thing
        assert copy.copy(thing) == thing


def test_what_a_notebook_shows_as_a_table_is_one_for_pandas(corpus):
    annotation, context = corpus[0].annotations[0], corpus[0].context
    clauses = annotation.to_pandas()
    assert list(clauses["clause"]) == ["EVENT", "OBJECT", "PATH", "OBJECT"]
    assert list(clauses["words"]) == ["Go to the pallet", "", "to the pallet", "the pallet"]
    assert list(clauses["correct"]) == list(annotation.correct)
    objects = context.to_pandas()
    assert list(objects["id"]) == [o.id for o in context.objects]
    assert list(objects["x"]) == [o.trajectory.xyz[0, 0] for o in context.objects]
    first, *others = context.objects
    painted = replace(context, objects=(replace(first, colours=("red", "black")), *others))
    assert painted.to_pandas()["colours"][0] == "red, black"


def test_trees_are_a_sequence_and_a_table():
    sure = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))")
    other = parse_brackets("EVENT(r = Go to, l = OBJ(f = the truck))")
    parse = Parse("Go to the truck", (Tree(tuple(sure), 0.75), Tree(tuple(other), 0.25)))
    assert len(parse) == len(list(parse)) == 2
    assert parse[0].sdcs == parse.sdcs
    table = parse.to_pandas()
    assert list(table["probability"]) == [0.75, 0.25]
    assert table["clauses"][1].startswith("EVENT_1(r = Go to")
