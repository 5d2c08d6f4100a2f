"""``import ct``: what an outsider types, and what a notebook shows."""

from __future__ import annotations

import inspect
import json
import re
import subprocess
import sys
from dataclasses import replace
from html import unescape
from pathlib import Path

import pytest

import ct
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.importer_registry import importers
from g3.annotation import Command
from g3.errors import CorpusError, ModelError
from g3.inference.grounder import Grounder, open_model
from g3.language.parsing.sdc_parser import SDCParser
from g3.learning.grounding_model import GroundingModel
from g3.sdc.sdc_notation import parse_brackets
from tests.tiny_corpus import tiny_corpus

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "tests/data/slu_core_small"


@pytest.fixture(scope="module")
def corpus() -> Corpus:
    return tiny_corpus()


@pytest.fixture(scope="module")
def model(corpus) -> GroundingModel:
    return ct.train(corpus)


def test_it_is_imported_without_what_is_heavy():
    heavy = "sorted({'numpy', 'scipy', 'rich', 'click'} & sys.modules.keys())"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys, ct; print({heavy})"],
        capture_output=True, text=True, check=True, cwd=ROOT,
    )  # fmt: skip
    assert done.stdout == "[]\n"


def test_a_corpus_is_loaded_by_name_by_path_and_as_it_is(corpus, tmp_path):
    corpus.save(tmp_path / "tiny")
    assert ct.load(corpus) is corpus
    assert ct.load(tmp_path / "tiny").hash == ct.load(str(tmp_path / "tiny")).hash == corpus.hash
    assert ct.load("warehouse").name == "warehouse"
    with pytest.raises(CorpusError, match="no folder or bundled corpus"):
        ct.load("nowhere")


def test_a_corpus_is_a_sequence_of_commands(corpus):
    assert len(corpus) == len(list(corpus)) == 8
    assert corpus[0].text == "Go to the pallet" == corpus[corpus[0].id].text
    assert [e.id for e in corpus[-2:]] == [e.id for e in list(corpus)[-2:]]
    assert [a.source for a in corpus[0].annotations] == ["positive", "random"]
    assert corpus[0].context is corpus.contexts["to_pallet/world"]
    assert corpus[0].sdcs == corpus[0].annotations[0].sdcs
    with pytest.raises(KeyError):
        corpus["nobody said this"]
    with pytest.raises(IndexError):
        corpus[8]


def test_a_corpus_as_a_table(corpus):
    table = corpus.to_pandas()
    assert list(table["text"][:2]) == ["Go to the pallet", "Go to the pallet"]
    assert list(table["annotations"]) == [2] * 8
    assert table["clauses"][0].startswith("EVENT_1(r = Go")


def test_a_corpus_that_nobody_annotated():
    command = Command("one", "Take <b>it</b>", "here")
    corpus = Corpus("typed", {}, {"one": command}, (), (), "us", "MIT", "")
    (entry,) = corpus
    assert (entry.sdcs, entry.annotation, entry.context) == ((), None, None)
    assert "Take &lt;b&gt;it&lt;/b&gt;" in entry._repr_html_()
    with pytest.raises(CorpusError, match="no world to follow"):
        ct.follow(entry)


def test_what_people_typed_is_text_in_a_notebook():
    bad = "<script>alert(1)</script>"
    command = Command("x", f"Go to the {bad} pallet", bad)
    corpus = Corpus(bad, {}, {"x": command}, (), (), bad, bad, "")
    shown = [corpus, corpus[0], ct.parse(corpus[0])]
    for thing in shown:
        assert "<script" not in thing._repr_html_(), thing
        assert "alert(1)" in thing._repr_html_()


def test_examples_and_annotations_are_drawn(corpus):
    html = corpus[0]._repr_html_()
    assert html.startswith("<p><strong>Go to the pallet</strong>")
    assert "<svg" in html
    assert re.search("<td>OBJECT</td><td>the pallet</td><td>tire pallet pallet</td>", html)


def test_training_and_the_model_by_path(corpus, model, tmp_path):
    model.save(tmp_path / "small")
    for name in ("small", "small.npz", "small.json"):
        grounder = Grounder.load(tmp_path / name)
        assert grounder.cost.model.l2 == model.l2
    assert open_model(model) is model
    with pytest.raises(ModelError, match="no file or model") as error:
        Grounder.load("nothing")
    assert "warehouse" in error.value.fix


def test_training_says_what_the_command_line_says(corpus, tmp_path, capsys):
    corpus.save(tmp_path / "tiny")
    options = ["--negatives", "hard", "--ablate", "labels", "--l2", "2"]
    out = tmp_path / "cli.npz"
    assert (
        run(["train", "g3", "--corpus", str(tmp_path / "tiny"), "--out", str(out), *options]) == 0
    )
    model = ct.train(corpus, l2=2, negatives="hard", ablate=["labels"])
    model.save(tmp_path / "python.npz")
    assert (tmp_path / "python.npz").read_bytes() == out.read_bytes()


def test_an_extractor_is_trained_and_used(corpus, tmp_path):
    extractor = ct.train(corpus, "parse", l2=1)
    assert isinstance(extractor, SDCParser)
    extractor.save(tmp_path / "sdc.npz")
    by_model = ct.parse("Go to the truck", extractor=extractor)
    by_file = ct.parse("Go to the truck", extractor=tmp_path / "sdc.npz")
    assert by_model.sdcs == by_file.sdcs
    assert by_model.sdcs[0].type == "EVENT"


def test_table_1_is_that_of_the_command_line(corpus, tmp_path, capsys):
    corpus.save(tmp_path / "tiny")
    table = ct.evaluate(corpus, draws=50, seed=3, negatives="hard", ablate=["labels"])
    options = ["--draws", "50", "--seed", "3", "--negatives", "hard", "--ablate", "labels"]
    source = ["--corpus", str(tmp_path / "tiny"), "--cv", "scenario"]
    assert run(["eval", "--table", "1", *source, *options]) == 0
    assert capsys.readouterr().out == f"{table}\n"
    assert run(["eval", "--table", "1", *source, *options, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == table.document
    assert run(["eval", "--table", "1", *source, *options, "--format", "latex"]) == 0
    assert capsys.readouterr().out == f"{table.to_latex()}\n"


def test_a_table_is_rows(corpus):
    table = ct.evaluate(corpus, draws=20)
    assert len(table) == len(list(table)) == 5
    assert table[0]["type"] == "OBJECT"
    assert [row["type"] for row in table[-1:]] == ["overall"]
    frame = table.to_pandas()
    assert frame["f"][4] == table[4]["f"]
    assert frame["paper.f"][4] == 0.89
    assert table.text in unescape(table._repr_html_())
    assert table.to_csv().startswith("type,precision")


def test_a_model_and_another_corpus_are_tested(corpus, model):
    apart = tiny_corpus(shift=40.0)
    by_model = ct.evaluate(apart, train=model, draws=20)
    by_corpus = ct.evaluate(apart, train=corpus, draws=20)
    assert [row["f"] for row in by_model] == [row["f"] for row in by_corpus]
    with pytest.raises(CorpusError, match="training side"):
        ct.evaluate(corpus, train=model)


def test_table_2(published):
    table = ct.evaluate(published[0], table=2, draws=200)
    assert [row["configuration"] for row in table] == ["original", "random"]
    assert table[0]["precision"] > 0.8 > 0.2 > table[1]["precision"]


def test_there_is_no_table_4(corpus):
    with pytest.raises(CorpusError, match=r"table can.t be 4 \(give one of 1, 2, 3"):
        ct.evaluate(corpus, table=4)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def follower(corpus) -> Grounder:
    return Grounder.load(ct.train(corpus, "follow"))


def test_a_command_is_followed(corpus, follower):
    sdcs = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))")
    result = ct.follow(sdcs, corpus[0].context, model=follower, explain=True)
    assert result.plan is not None
    html = result._repr_html_()
    assert html.count("<svg") == 2
    assert f"<td>{result.plan.words.action(result.plan.actions[0])}</td>" in html
    assert "<polyline" in html
    text = ct.follow(corpus[0], model=follower, top=2)  # an entry has its own world
    assert text.start is not None
    assert text.start.context.id == corpus[0].context.id


def test_why_there_is_no_plan_is_shown(corpus, follower):
    sdcs = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the lighthouse)))")
    result = ct.follow(sdcs, corpus[0].context, model=follower)
    assert result.plan is None
    assert result.note in result._repr_html_()


def test_worlds_are_found_by_name(follower):
    sdcs = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the trailer)))")
    named = ct.follow(sdcs, "dock_pick_up_tires", model=follower)
    of_corpus = ct.follow(sdcs, "warehouse:dock_pick_up_tires", model=follower)
    assert named.start is not None
    assert of_corpus.start is not None
    assert {o.id for o in named.start.context.objects} == {
        o.id for o in of_corpus.start.context.objects
    }
    with pytest.raises(CorpusError, match="no context"):
        ct.follow(sdcs, "warehouse:atlantis", model=follower)


def test_each_importer_has_a_function(tmp_path):
    ours = [one for one in importers() if one.target.startswith("corpus_tools.")]
    for importer in ours:
        function = getattr(ct, f"import_{importer.name.replace('-', '_')}")
        options = {one.name: one.default for one in importer.options}
        parameters = inspect.signature(function).parameters
        assert {name: parameters[name].default for name in options} == options
    assert set(dir(ct)) == set(ct.__all__)  # which notebooks complete
    with pytest.raises(CorpusError, match="slu-core"):
        ct.import_corpus("mars", tmp_path)


def test_lists_of_commands_are_parsed_and_followed(corpus, follower):
    texts = ["Go to the trailer", "Lift the pallet"]
    parses = ct.parse(texts)
    assert [p.text for p in parses] == texts
    assert [p.text for p in ct.parse(corpus)] == [e.text for e in corpus]
    assert parses[0].sdcs == ct.parse(texts[0]).sdcs
    results = ct.follow(texts, "dock_pick_up_tires", model=follower)
    alone = ct.follow(texts[0], "dock_pick_up_tires", model=follower)
    assert [r.plan is not None for r in results] == [True, True]
    assert results[0].plan.actions == alone.plan.actions
    assert ct.parse([]) == []


def test_a_learning_curve(corpus):
    curve = ct.learning_curve(corpus, repeats=2)
    assert {row["type"] for row in curve} >= {"OBJECT", "overall"}
    whole = [row for row in curve if row["type"] == "overall"]
    assert all(0 <= row["low"] <= row["error"] <= row["high"] <= 1 for row in whole)
    assert "SDCs" in str(curve)
    assert curve.to_csv().startswith("type,sdcs,error")
    with pytest.raises(CorpusError, match="repeats can't be 0"):
        ct.learning_curve(corpus, repeats=0)
    with pytest.raises(CorpusError, match="no option 'ablat'"):
        ct.learning_curve(corpus, ablat="labels")


def test_table_2_can_be_tried_without_a_corpus():
    table = ct.evaluate(table=2, draws=20)
    assert table.document["judged_by"] == "simulated raters"


def test_importing_and_exporting(tmp_path):
    corpus = ct.import_slu_core(SMALL, salt="s", out=tmp_path / "small")
    assert ct.load(tmp_path / "small").hash == corpus.hash
    assert (tmp_path / "small/import-report.json").exists()
    assert ct.export(corpus, tmp_path / "own") == tmp_path / "own"
    assert ct.load(tmp_path / "own").hash == corpus.hash
    ct.export(tmp_path / "own", tmp_path / "theirs", to="slu-core")
    again = ct.import_corpus("slu-core", tmp_path / "theirs")
    assert {e.text for e in again} == {e.text for e in corpus}
    with pytest.raises(CorpusError, match=r"label-studio, lerobot, lerobot-2\.1, slu-core"):
        ct.export(corpus, tmp_path / "x", to="papyrus")
    with pytest.raises(CorpusError):
        ct.export(corpus, tmp_path / "own")  # it is there
    ct.export(corpus, tmp_path / "own", force=True)


@pytest.mark.slow
def test_a_plan_and_a_scenario_are_filmed(corpus, follower, tmp_path):
    small = {"size": (96, 96), "fps": 2, "quality": "draft"}
    sdcs = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the trailer)))")
    result = ct.follow(sdcs, "dock_pick_up_tires", model=follower)
    video = ct.render(result, tmp_path / "plan.mp4", **small)
    assert video.stat().st_size > 1000
    assert (tmp_path / "plan.mcap").exists()
    assert result.start.site == "depot"
    in_yard = replace(result, start=replace(result.start, site="yard"))
    assert ct.render(in_yard, tmp_path / "yard.mp4", **small).read_bytes() != video.read_bytes()
    video = ct.render("dock_go_to_receiving", tmp_path, **small)
    assert video == tmp_path / "dock_go_to_receiving/video.mp4"
    assert video.stat().st_size > 1000
    nothing = ct.follow(parse_brackets("OBJ(f = the trailer)"), corpus[0].context, model=follower)
    with pytest.raises(CorpusError, match="no plan"):
        ct.render(nothing, tmp_path / "nothing.mp4")
