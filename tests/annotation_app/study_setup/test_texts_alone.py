"""A treebank goes through the app without videos: people correct its trees."""

from __future__ import annotations

from pathlib import Path

import pytest

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.importers.treebank import read_treebank
from g3.sdc.sdc_notation import format_brackets, parse_brackets, to_json
from tests.annotation_app.browser import Browser
from tests.small_treebank import write_treebank

GO = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the pallet)))"


@pytest.fixture
def treebank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = write_treebank(tmp_path / "mine")
    line = '{"id": "x", "person": "p1", "text": "Lift it 1.5 m.", "trees": [%s]}\n'
    with (folder / "trees.jsonl").open("a") as file:
        file.write(line % '"EVENT(r = Lift, l = OBJ(f = it), l2 = OBJ(f = 1.5 m))"')
    return folder


def import_into(instance: Path, treebank: Path) -> None:
    command = ["annotate", "import", str(treebank), "--instance", str(instance)]
    assert run([*command, "--study", "trees"]) == 0


def tree(notation: str, text: str) -> list[dict[str, object]]:
    return to_json(parse_brackets(notation, command=text))


def test_people_correct_trees_and_export_them_in_the_same_form(
    treebank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    instance, out = tmp_path / "instance", tmp_path / "out"
    import_into(instance, treebank)
    assert "study trees: 17 commands, 17 to correct, 0 to segment" in capsys.readouterr().out
    config = open_instance(instance)
    engine = open_database(config.database)
    expert = Browser(create_app(config, engine), "annotator", "trees")
    before = {one.id: one for one in read_treebank(treebank)}
    lifted = {"type": "OBJECT", "f": [["1", 8], [".", 9], ["5", 10], ["m", 12]]}  # the page's words
    lift = {"type": "EVENT", "f": [{"type": "OBJECT"}], "r": [["Lift", 0]], "l2": [lifted]}
    put = "EVENT(r = Put on, l = OBJ(f = the pallet))"
    sent = {
        "Go to the truck.": [],
        "Put the pallet on the truck.": tree(put, "Put the pallet on the truck."),
        "Go to the pallet, no, to the truck.": tree(GO, "Go to the pallet, no, to the truck."),
        "Good morning!": tree("OBJ(f = morning)", "Good morning!"),
        "Lift it 1.5 m.": [lift],
    }
    for own in before.values():
        page = expert.lease("segment", "trees").json
        assert expert.client.get("/s/trees/segment").status_code == 200
        payload = page["payload"]
        assert (payload["command"], payload["video"]) == (own.text, None)
        assert payload["suggestion"] == to_json(own.trees)  # also where there are none
        answer = expert.answer(page["item"], {"sdcs": sent.get(own.text, payload["suggestion"])})
        assert answer.status_code == 200, answer.text
    engine.dispose()

    export = ["annotate", "export", "--instance", str(instance), "--study", "trees"]
    assert run([*export, str(out), "--format", "treebank"]) == 0
    exported = {one.id: one for one in read_treebank(out)}
    told = {name: format_brackets(one.trees) for name, one in exported.items()}
    assert told["p1-1"] == ""
    assert told["p1-2"] == "EVENT_1(r = Put on, l = OBJ_2(f = the pallet))"
    assert told["p1-3"] == "EVENT_1(r = Go, l = PATH_2(r = to, l = OBJ_3(f = the pallet)))"
    assert exported["p1-3"].taken_back == ()  # a clause has its words now
    assert told["p2-4"] == "OBJ_1(f = morning)"
    assert told["x"] == "EVENT_1(r = Lift, l2 = OBJ_2(f = 1.5 m))"
    same = [name for name, one in before.items() if one.text not in sent]
    assert len(same) == 6
    assert [exported[name] for name in same] == [before[name] for name in same]
    assert run([*export, str(tmp_path / "corpus")]) == 0
    assert validate(tmp_path / "corpus") == []
    assert len(Corpus.load(tmp_path / "corpus").annotations) == 17


def test_an_answer_is_empty_or_has_words(treebank: Path, tmp_path: Path) -> None:
    instance = tmp_path / "instance"
    import_into(instance, treebank)
    config = open_instance(instance)
    engine = open_database(config.database)
    expert = Browser(create_app(config, engine), "annotator", "trees")
    page = expert.lease("segment", "trees").json
    refused = expert.answer(page["item"], {"sdcs": [{"type": "OBJECT"}]})
    assert "Mark at least one clause." in refused.text
    engine.dispose()
