"""What is exported is read back by the other projects' own programs."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from corpus_tools.exporters.csv_tables import csv_files
from corpus_tools.exporters.export_registry import export_corpus_to
from corpus_tools.exporters.label_studio import label_studio_files
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.importers.slu_core.slu_corpus import import_slu_core
from corpus_tools.runtime import parquet
from g3.annotation import Judgment
from g3.errors import FormatError
from g3.sdc.sdc_notation import format_brackets
from tests.tiny_corpus import tiny_corpus

PAPER = Path(__file__).parents[4] / "shared" / "data" / "slu_core" / "data"


@pytest.fixture
def corpus():
    whole = tiny_corpus()
    first = next(iter(whole.commands.values()))
    judgment = Judgment("j", first.text, first.video, "another video", "SA", "rater", "mine")
    return replace(whole, judgments=(judgment,))


def loaded(folder: Path, cache: Path, config: str | None = None):
    datasets = pytest.importorskip("datasets", reason="datasets is not installed")
    datasets.disable_progress_bars()
    return datasets.load_dataset(str(folder), config, split="train", cache_dir=str(cache))


@pytest.mark.filterwarnings("ignore")
def test_datasets_reads_the_counts_and_the_content(corpus, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    export_corpus_to(corpus, "huggingface", tmp_path / "hf")
    commands = loaded(tmp_path / "hf", tmp_path / "cache")
    assert list(commands["text"]) == [c.text for c in corpus.commands.values()]
    annotations = loaded(tmp_path / "hf", tmp_path / "cache", "annotations")
    assert annotations.num_rows == len(corpus.annotations)
    for row, annotation in zip(annotations, corpus.annotations, strict=True):
        assert row["notation"] == format_brackets(annotation.sdcs)
        assert [clause["correct"] for clause in row["clauses"]] == list(annotation.correct)
    (judgment,) = loaded(tmp_path / "hf", tmp_path / "cache", "judgments")
    assert (judgment["rating"], judgment["shown_video"]) == ("SA", "another video")
    poses = loaded(tmp_path / "hf", tmp_path / "cache", "trajectories")
    robot = loaded(tmp_path / "hf", tmp_path / "cache", "contexts")[0]["objects"][0]
    assert {"liftable", "colours"} <= robot.keys()
    trajectory = next(iter(corpus.contexts.values())).agent.trajectory
    assert poses[robot["trajectory"]]["xyz"] == trajectory.xyz.tolist()
    mixed = poses.shuffle(seed=1)
    (own,) = mixed.filter(lambda row: row["id"] == robot["trajectory"])
    assert own["xyz"] == trajectory.xyz.tolist()
    assert "outcomes" not in (tmp_path / "hf" / "README.md").read_text()  # there are none


@pytest.mark.parametrize(
    ("licence", "ids"),
    [
        ("MIT", {"license": "mit"}),
        ("CC-BY-4.0", {"license": "cc-by-4.0"}),
        ("ask us", {"license": "other", "license_name": "ask us"}),
        ("", {"license": "other", "license_name": "unknown"}),
    ],
)
def test_the_card_names_the_licence_as_the_hub_does(corpus, tmp_path: Path, licence, ids):
    own = replace(corpus, licence=licence, source="Written by us. Seed: 2011.")
    export_corpus_to(own, "huggingface", tmp_path / "hf")
    _, head, text = (tmp_path / "hf" / "README.md").read_text().split("---\n", 2)
    card = yaml.safe_load(head)
    assert {name: card[name] for name in card if name.startswith("license")} == ids
    assert card["task_categories"] == ["robotics"]
    assert "Source: Written by us. Seed: 2011. Licence: " in text


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.skipif(not PAPER.is_dir(), reason="the paper's corpus is not here")
def test_datasets_reads_the_counts_of_the_papers_corpus(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    corpus, _ = import_slu_core(PAPER, salt="salt")
    export_corpus_to(corpus, "huggingface", tmp_path / "hf")
    counts = {
        name: loaded(tmp_path / "hf", tmp_path / "cache", name).num_rows
        for name in ("commands", "contexts", "annotations", "judgments")
    }
    assert counts == {
        "commands": len(corpus.commands),
        "contexts": len(corpus.contexts),
        "annotations": len(corpus.annotations),
        "judgments": len(corpus.judgments),
    }


def test_without_pyarrow_the_error_says_how_to_get_it(corpus, tmp_path: Path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(FormatError) as error:
        export_corpus_to(corpus, "huggingface", tmp_path / "hf")
    assert "corpus-tools-g3[parquet]" in error.value.fix
    assert not (tmp_path / "hf").exists()
    monkeypatch.undo()
    assert parquet.import_pyarrow()


def test_the_validator_of_universal_dependencies_passes_a_whole_corpus(tmp_path: Path):
    pytest.importorskip("spacy", reason="the extra `language` is not installed")
    udtools = pytest.importorskip("udtools", reason="udtools is not installed")
    conllu = pytest.importorskip("conllu", reason="conllu is not installed")
    corpus = open_corpus("warehouse")
    export_corpus_to(corpus, "conllu", tmp_path / "ud")
    file = tmp_path / "ud" / "corpus.conllu"
    state = udtools.Validator(lang="en", level=2).validate_files([str(file)])
    assert state.passed(), str(state)
    sentences = conllu.parse(file.read_text("utf-8"))
    assert [s.metadata["command_id"] for s in sentences] == list(corpus.commands)
    annotated = {a.command.id for a in corpus.annotations}
    for sentence in sentences:
        clauses = [(word["misc"] or {}).get("SDC") for word in sentence]
        assert any(clauses) == (sentence.metadata["command_id"] in annotated)


def test_label_studio_gets_regions_that_are_in_the_text(corpus):
    files = label_studio_files(corpus)
    config = ElementTree.fromstring(files["label-config.xml"])
    (labels,) = config.iter("Labels")
    names = {label.get("value") for label in labels}
    tasks = json.loads(files["tasks.json"])
    assert len(tasks) == len(corpus.commands)
    assert {label.get("name") for label in config.iter("Text")} == {labels.get("toName")}
    relations = {relation.get("value") for relation in config.iter("Relation")}
    found = 0
    for task in tasks:
        text = task["data"]["command"]
        for prediction in task.get("predictions", ()):
            regions = {r["id"] for r in prediction["result"] if r["type"] == "labels"}
            for result in prediction["result"]:
                if result["type"] == "relation":
                    assert {result["from_id"], result["to_id"]} <= regions
                    assert set(result["labels"]) <= relations
                    continue
                found += 1
                value = result["value"]
                assert text[value["start"] : value["end"]] == value["text"]
                assert set(value["labels"]) <= names
                assert (result["from_name"], result["to_name"]) == (
                    labels.get("name"), labels.get("toName"),
                )  # fmt: skip
    assert found > len(tasks)


def test_a_clause_in_two_pieces_is_two_related_regions():
    corpus = open_corpus("warehouse")
    split = next(
        annotation
        for annotation in corpus.annotations
        if any(re.match(r"EVENT_1\(r = (Put|Set) down", format_brackets([sdc]))
               for sdc in annotation.sdcs)
        and not re.search(r"(?i)(put|set) down", annotation.command.text)
    )  # fmt: skip
    tasks = json.loads(label_studio_files(corpus)["tasks.json"])
    (task,) = [t for t in tasks if t["data"]["command_id"] == split.command.id]
    result = task["predictions"][0]["result"]
    joined = [r for r in result if r["type"] == "relation" and r["labels"] == ["same clause"]]
    texts = {r["id"]: r["value"]["text"] for r in result if r["type"] == "labels"}
    assert "down" in {texts[r["to_id"]].lower() for r in joined}


def test_tables_have_a_row_for_each_record(corpus):
    files = csv_files(corpus)
    rows = {
        name: list(csv.DictReader(content.decode().splitlines())) for name, content in files.items()
    }
    assert [row["text"] for row in rows["commands.csv"]] == [
        command.text for command in corpus.commands.values()
    ]
    assert len(rows["clauses.csv"]) == sum(len(a.correct) for a in corpus.annotations)
    first = corpus.annotations[0]
    mine = [row for row in rows["clauses.csv"] if row["annotation"] == first.id]
    assert [row["correct"] for row in mine] == [
        {True: "right", False: "wrong", None: ""}[label] for label in first.correct
    ]
    assert len(rows["objects.csv"]) == sum(len(c.objects) for c in corpus.contexts.values())
    assert rows["judgments.csv"][0]["rating"] == "SA"


def test_slu_core_is_read_again(corpus, tmp_path: Path):
    export_corpus_to(corpus, "slu-core", tmp_path / "out")
    found, _ = import_slu_core(tmp_path / "out", salt="salt")
    assert len(found.annotations) == len(corpus.annotations)


def test_exports_are_the_same_each_time(corpus, tmp_path: Path):
    for to in ("csv", "huggingface", "label-studio", "lerobot", "slu-core"):
        for folder in ("a", "b"):
            export_corpus_to(corpus, to, tmp_path / f"{to}-{folder}")
        first, second = (
            {f.relative_to(tmp_path / n): f.read_bytes() for f in (tmp_path / n).rglob("*.*")}
            for n in (f"{to}-a", f"{to}-b")
        )
        assert list(first.values()) == list(second.values())
