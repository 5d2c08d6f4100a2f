"""``ct annotate`` as people use it: real processes, and an export that trains."""

from __future__ import annotations

import csv
import io
import json
import urllib.request
from collections import Counter
from pathlib import Path

import pyarrow.parquet
import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.core.config import open_instance
from annotation_app.export.corpus_export import export_corpus
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database, reading
from annotation_app.store.models import Answer, Study
from annotation_app.work.handing_out import find_study
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.exporters.csv_tables import safe_cell
from corpus_tools.importers.authored.bundled import open_corpus
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser, described, installation_of, rows_in
from tests.annotation_app.real_server import started
from tests.annotation_app.rendered import VIDEOS, render_contexts
from tests.tiny_corpus import tiny_corpus

GO = "Drive to the {0}"
TREE = "EVENT(r = Drive, l = PATH(r = to, l = OBJ(f = the {0})))"


def annotate_all(app: Flask) -> None:
    """Two people describe each video; one of them does all the rest."""
    workers = [Browser(app) for _ in range(2)]
    names: dict[str, str] = {}
    for number, worker in enumerate(workers):
        for _ in VIDEOS:
            noun = ("truck", "pallet")[number]
            worker.do("describe", described(GO.format(noun)))
    expert = Browser(app)
    while expert.lease("segment").status_code == 200:
        page = expert.take("segment")
        noun = page["payload"]["command"].split()[-1]
        sdcs = to_json(parse_brackets(TREE.format(noun), command=page["payload"]["command"]))
        expert.answer(page["item"], {"sdcs": sdcs})
    while expert.lease("ground").status_code == 200:
        page = expert.take("ground")
        thing = page["payload"]["map"]["objects"][0]["id"]
        names[thing] = page["item"]
        node = next(c["node"] for c in page["payload"]["clauses"] if c["type"] == "OBJECT")
        expert.answer(page["item"], {"groundings": {str(node): {"objects": [thing]}}})
    while expert.lease("check").status_code == 200:
        page = expert.take("check")
        verdicts = {str(c["node"]): False for c in page["payload"]["clauses"]}
        expert.answer(page["item"], {"verdicts": verdicts})
    rater = Browser(app)
    while rater.lease("rate").status_code == 200:
        rater.do("rate", {"rating": 4, "watched_s": 1.0})
    assert len(names) == 2 * len(VIDEOS)


def test_an_export_trains(app: Flask, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    annotate_all(app)
    instance = str(installation_of(app).config.instance)
    out = tmp_path / "corpus"
    assert run(["annotate", "export", str(out), "--instance", instance]) == 0
    assert "6 commands, 12 annotations, 12 judgments" in capsys.readouterr().out
    assert validate(out) == []
    assert run(["eval", "--table", "1", "--corpus", str(out)]) == 0
    assert run(["annotate", "export", str(out), "--instance", instance]) == 2

    slu_core, imported = tmp_path / "slu", tmp_path / "imported"
    command = ["annotate", "export", str(slu_core), "--format", "slu-core", "--instance", instance]
    capsys.readouterr()
    assert run([*command, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["folder"], told["annotations"]) == (str(slu_core), 12)
    assert run(["import", "slu-core", str(slu_core), "--out", str(imported)]) == 0
    read, original = Corpus.load(imported), Corpus.load(out)
    assert len(read.judgments) == len(original.judgments)
    assert Counter((a.source, a.sdcs) for a in read.annotations) == Counter(
        (a.source, a.sdcs) for a in original.annotations
    )


def test_an_export_without_annotations_says_how_to_get_some(
    app: Flask, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Browser(app).do("describe", described("Lift the tires."))
    instance = str(installation_of(app).config.instance)
    command = ["annotate", "export", str(tmp_path / "out"), "--instance", instance]
    assert run([*command, "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["annotations"] == 0
    assert "no annotations yet" in told.err
    assert all(task in told.err for task in ("Describe", "Segment", "Ground"))
    Browser(app).do("rate", {"rating": 4, "watched_s": 1.0})
    assert run([*command, "--json", "--force"]) == 0
    told = capsys.readouterr()
    assert (json.loads(told.out)["annotations"], json.loads(told.out)["judgments"]) == (0, 1)
    assert "no annotations" not in told.err  # ratings alone are what a study may be for


def test_tables(app: Flask, tmp_path: Path) -> None:
    Browser(app).do("describe", described('=HYPERLINK("http://evil")'))
    Browser(app).do("segment", {"sdcs": [{"type": "OBJECT", "f": [["HYPERLINK", 1]]}]})
    instance = str(installation_of(app).config.instance)
    files = {form: tmp_path / f"answers.{form}" for form in ("csv", "jsonl", "parquet")}
    for form, file in files.items():
        command = ["annotate", "export", str(file), "--format", form, "--instance", instance]
        assert run(command) == 0
    cells = list(csv.DictReader(io.StringIO(files["csv"].read_text())))
    assert [row["task"] for row in cells] == ["describe", "segment"]
    assert cells[1]["command"] == '\'=HYPERLINK("http://evil")'
    lines = [json.loads(line) for line in files["jsonl"].read_text().splitlines()]
    assert lines[0]["body"]["text"] == '=HYPERLINK("http://evil")'
    columns = pyarrow.parquet.read_table(files["parquet"]).to_pylist()
    told = [{name: json.loads(row[name]) for name in ("body", "metadata")} for row in columns]
    assert [row | more for row, more in zip(columns, told, strict=True)] == lines


def test_words_with_their_clauses(app: Flask, tmp_path: Path) -> None:
    pytest.importorskip("spacy", reason="the extra `language` is not installed")
    annotate_all(app)
    instance, file = str(installation_of(app).config.instance), tmp_path / "words.conllu"
    command = ["annotate", "export", str(file), "--format", "conllu", "--instance", instance]
    assert run(command) == 0
    first, *_ = file.read_text().split("\n\n")
    head, text, suggestion, *words = first.splitlines()
    assert head.startswith("# sent_id = tests-")
    assert suggestion.startswith("# suggestion = shown, likeness ")
    noun = text.split()[-1]
    assert text == f"# text = Drive to the {noun}"
    columns = [word.split("\t") for word in words]
    assert [c[1] for c in columns] == ["Drive", "to", "the", noun]
    assert [c[9].split("|")[0] for c in columns] == [
        "SDC=EVENT_1.r", "SDC=PATH_2.r", "SDC=OBJECT_3.f", "SDC=OBJECT_3.f",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "text",
    ["=1", "+1", "-1", "@A1", "\t=1", "  =1", "\r1", "\n1", "＝1", "＋1", "－1", "＠A1", "﹦1",
     "−1", "\u3000=1", "\u00a0＝1", "\ufeff=1", "\u200b＝1"],
)  # fmt: skip
def test_no_cell_is_a_formula(text: str) -> None:
    assert safe_cell(text) == f"'{text}"


@pytest.mark.parametrize("text", ["", "a=1", "Go to +1", "≠", "１", "'=1", "–"])
def test_other_cells_stay_as_they_are(text: str) -> None:
    assert safe_cell(text) == text


READERS = (
    ["export", "out"],
    ["export", "out.csv", "--format", "csv"],
    ["backup", "out.gz", "--without-keys"],
    ["copy-media", "media"],
    ["check"],
    ["audit"],
    ["people", "list"],
    ["people", "block", "ann"],
    ["people", "erase", "--expired", "--dry-run"],
    ["tokens", "list"],
)


@pytest.mark.parametrize("command", READERS, ids=" ".join)
@pytest.mark.parametrize("database", ["", "no.sqlite", "sqlite:///no.sqlite"])
def test_commands_that_read_make_nothing(
    command: list[str],
    database: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    given = ["--database", database] if database else []
    assert run(["annotate", *command, *given]) == 2
    assert "there is no installation here" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    assert run(["annotate", "init", "my.yaml"]) == 0
    assert run(["annotate", "check", "my.yaml", *given]) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["my.yaml"]


def test_a_corpus_can_be_imported_edited_and_exported(tmp_path: Path) -> None:
    corpus = tiny_corpus()
    folder = tmp_path / "tiny"
    corpus.save(folder)
    videos = render_contexts(tmp_path / "videos", corpus)
    instance = tmp_path / "instance"
    command = ["annotate", "import", str(folder), "--videos", str(videos)]
    assert run([*command, "--instance", str(instance)]) == 0
    out = tmp_path / "out"
    assert run(["annotate", "export", str(out), "--instance", str(instance)]) == 0
    exported = Corpus.load(out)
    assert exported.commands == corpus.commands
    assert sorted(exported.annotations, key=lambda a: a.id) == sorted(
        corpus.annotations, key=lambda a: a.id
    )


@pytest.mark.slow
def test_the_bundled_corpus_can_be_edited(tmp_path: Path) -> None:
    """What an adjudicator changes is exported as they left it, all else as it was."""
    corpus = open_corpus("warehouse")
    videos = render_contexts(tmp_path / "videos", corpus)
    instance = tmp_path / "instance"
    command = ["annotate", "import", "warehouse", "--videos", str(videos)]
    assert run([*command, "--instance", str(instance)]) == 0
    config = open_instance(instance)
    engine = open_database(config.database)
    changed = next(a for a in corpus.annotations if a.source == "positive" and len(a.sdcs) == 1)
    (study,) = rows_in(engine, select(Study))
    item = next(
        answer.item_id
        for answer in rows_in(engine, select(Answer).where(Answer.task == "segment"))
        if answer.subject.endswith(f" {changed.id}")
    )
    editor = Browser(create_app(config, engine), "adjudicator", study.name)
    word = all_words(changed.sdcs[0])[0]
    tree = [{"type": "OBJECT", "f": [[word.text, word.start]]}]
    assert editor.adjudicate(item, {"sdcs": tree}).status_code == 200
    page = editor.lease("ground", study.name)
    assert page.json["payload"]["command"] == changed.command.text
    body = {"groundings": {"0": {"cant_tell": True}}, **editor.watched(page.json)}
    assert editor.answer(page.json["item"], body).status_code == 200
    engine.dispose()

    out = tmp_path / "out"
    assert run(["annotate", "export", str(out), "--instance", str(instance)]) == 0
    exported = {a.id: a for a in Corpus.load(out).annotations}
    assert to_json(exported[changed.id].sdcs) == tree
    untouched = [a for a in corpus.annotations if a.command.id != changed.command.id]
    assert [exported[a.id] for a in untouched] == untouched


def test_the_server(tmp_path: Path, videos: Path) -> None:
    """init, serve and stop, as a stranger would."""
    study = tmp_path / "my-study.yaml"
    assert run(["annotate", "init", str(study)]) == 0
    assert run(["annotate", "init", str(study)]) == 2
    options = ["--videos", str(videos), "--instance", str(tmp_path / "i"), "--port", "0"]
    with started(tmp_path / "log", "annotate", str(study), *options) as server:
        address = f"http://localhost:{server.port}"
        with urllib.request.urlopen(f"{address}/api/openapi.json") as reply:
            assert json.load(reply)["openapi"] == "3.1.0"
        assert server.end() == 0
    assert f"{address}/s/my-study" in server.told
    assert f"{address}/setup/" in server.told
    engine = open_database(tmp_path / "i" / "annotation.sqlite")
    with reading(engine) as session:
        assert export_corpus(session, find_study(session, "my-study")).commands == {}
    engine.dispose()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("title: Commands", "study.yaml:1:1: the field 'name' is missing"),
        ("name: a\ntitle: b\ntasks: {}", "there are no tasks"),
        ("name: a\ntitle: b\ntasks:\n  sing: {}", "study.yaml:4:3"),
        ("name: a\ntitle: b\ntasks:\n  rate: {answers: 0}", "study.yaml:4:19: tasks.rate.answers"),
        ("name: a\ntitle: b\ncolour: red\ntasks: {rate: {}}", "there is no such field"),
        ("name: a\ntitle: b\nvideos: none\ntasks: {rate: {}}", "there are no videos"),
    ],
)
def test_mistakes_in_a_study(
    tmp_path: Path, change: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    study = tmp_path / "study.yaml"
    study.write_text(change)
    assert run(["annotate", str(study), "--instance", str(tmp_path / "i")]) == 2
    assert told in capsys.readouterr().err
