"""Label Studio's own package reads the export: its validator, its types, its converter.

`label-studio-sdk` wants an older OpenCV than videos do, so it can't be among the test's packages:
`pip install label-studio-sdk` in another environment, and run this module there. Elsewhere the same
rules are checked field by field, as `LabelInterface` has them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.exporters.label_studio import label_studio_files
from corpus_tools.importers.authored.bundled import open_corpus
from g3.sdc.clauses import breadth_first

OWN = "label-studio-sdk is not installed"
REGION = {"id", "from_name", "to_name", "type", "value"}
RELATION = {"type", "direction", "from_id", "to_id", "labels"}


@pytest.fixture(scope="module")
def corpus() -> Corpus:
    return open_corpus("warehouse")


@pytest.fixture(scope="module")
def exported(corpus) -> tuple[str, list[dict[str, Any]]]:
    files = label_studio_files(corpus)
    return files["label-config.xml"].decode(), json.loads(files["tasks.json"])


def predictions(tasks: list[dict[str, Any]]) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    for task in tasks:
        for prediction in task.get("predictions", ()):
            yield task, prediction


def labelled(result: list[dict[str, Any]]) -> list[tuple[int, int, str]]:
    values = [part["value"] for part in result if part["type"] == "labels"]
    return [(v["start"], v["end"], v["labels"][0]) for v in values]


def test_its_validator_finds_nothing(exported):
    interface = pytest.importorskip("label_studio_sdk.label_interface", reason=OWN)
    objects = pytest.importorskip("label_studio_sdk.label_interface.objects", reason=OWN)
    config, tasks = exported
    project = interface.LabelInterface(config)
    project.validate()
    for task in tasks:
        known = objects.TaskValue.model_validate(task)
        assert project.validate_task({"data": known.data})
    found = [project.validate_prediction(p, return_errors=True) for _, p in predictions(tasks)]
    assert len(found) > 300
    assert [problem for problems in found for problem in problems] == []
    _, broken = next(predictions(json.loads(json.dumps(tasks))))  # it does look
    broken["result"][0]["value"]["labels"] = ["PERSON"]
    assert project.validate_prediction(broken, return_errors=True)


def test_its_converter_gives_the_clauses_back(corpus, exported, tmp_path: Path):
    converter = pytest.importorskip("label_studio_sdk.converter", reason=OWN)
    config, tasks = exported
    agreed = [
        {
            "id": number,
            "data": task["data"],
            "annotations": [{"id": number, "completed_by": 1, "result": prediction["result"]}],
        }
        for number, (task, prediction) in enumerate(predictions(tasks))
    ]
    (tmp_path / "done.json").write_text(json.dumps(agreed))
    own = converter.Converter(config, None, download_resources=False)
    own.convert_to_json_min(str(tmp_path / "done.json"), str(tmp_path / "min"), is_dir=False)
    rows = json.loads((tmp_path / "min/result.json").read_text())
    assert [row["command"] for row in rows] == [one["data"]["command"] for one in agreed]
    for row, (_, prediction) in zip(rows, predictions(tasks), strict=True):
        spans = [(v["start"], v["end"], v["labels"][0]) for v in row["clause"]]
        assert sorted(spans) == sorted(labelled(prediction["result"]))
    own.convert_to_conll2003(str(tmp_path / "done.json"), str(tmp_path / "conll"), is_dir=False)
    lines = (tmp_path / "conll/result.conll").read_text().splitlines()
    assert {"B-EVENT", "B-OBJECT", "B-PLACE", "B-PATH"} <= {
        line.split()[-1] for line in lines if line
    }
    assert len(corpus) == len(tasks)


def test_field_by_field_as_its_validator_has_it(corpus, exported):
    config, tasks = exported
    root = ElementTree.fromstring(config)
    (control,), (text,) = root.iter("Labels"), root.iter("Text")
    tags = [tag.get("name") for tag in root.iter() if tag.get("name")]
    assert len(tags) == len(set(tags))
    assert control.get("toName") == text.get("name")
    assert text.get("value") == "$command"
    labels = {label.get("value") for label in control.iter("Label")}
    relations = {relation.get("value") for relation in root.iter("Relation")}
    first = {}
    for annotation in corpus.annotations:
        first.setdefault(annotation.command.id, annotation)
    assert {t["data"]["command_id"] for t, _ in predictions(tasks)} == first.keys()
    for task, prediction in predictions(tasks):
        assert prediction.keys() == {"model_version", "result"}
        said = task["data"]["command"]
        regions = [part for part in prediction["result"] if part["type"] == "labels"]
        ids = [region["id"] for region in regions]
        assert len(ids) == len(set(ids))
        for region in regions:
            assert region.keys() == REGION
            assert region["from_name"] == control.get("name")
            assert region["to_name"] == text.get("name")
            value = region["value"]
            assert value.keys() == {"start", "end", "text", "labels"}
            assert 0 <= value["start"] < value["end"] <= len(said)
            assert said[value["start"] : value["end"]] == value["text"]
            assert len(value["labels"]) == 1
            assert set(value["labels"]) <= labels
        for part in prediction["result"]:
            if part["type"] != "labels":
                assert part.keys() == RELATION
                assert part["type"] == "relation"
                assert part["direction"] in ("left", "right", "bi")
                assert {part["from_id"], part["to_id"]} <= set(ids)
                assert set(part["labels"]) <= relations
        clauses = list(breadth_first(first[task["data"]["command_id"]].sdcs))
        named = {int(name.partition("-")[0]) for name in ids}
        assert named == {n for n, c in enumerate(clauses) if (*c.relation, *c.words)}


def test_videos_are_shown_by_their_addresses_or_else_by_their_names(corpus: Corpus):
    def shown(*videos: str) -> list[tuple[str, str]]:
        some = list(corpus.commands.items())[: len(videos)]
        named = {key: replace(c, video=v) for (key, c), v in zip(some, videos, strict=True)}
        own = replace(corpus, commands=named, annotations=())
        files = label_studio_files(own)
        tree = ElementTree.fromstring(files["label-config.xml"])
        return [(e.tag, e.get("value")) for e in tree if e.get("value") == "$video"]

    assert shown("dock", "hall") == [("Header", "$video")]
    assert shown("https://here/a.mp4", "/data/b.mp4") == [("Video", "$video")]
    assert shown("https://here/a.mp4", "") == [("Header", "$video")]
    assert shown("", "") == []
