"""Things in the pictures of one's own videos, from a COCO file to a table of groundings."""

from __future__ import annotations

import copy
import csv
import io
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from sqlalchemy import select

from annotation_app.cli import served_studies
from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened
from annotation_app.store.models import Answer, Item
from annotation_app.study_setup.coco_things import read_things
from annotation_app.study_setup.study_starting import read_parts
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from g3.errors import CorpusError, FormatError
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser, described, rows_in
from tests.annotation_app.signing_in import signed_in
from tests.annotation_app.study_setup.clips import HEIGHT, WIDTH, clip
from tests.annotation_app.study_setup.test_own_videos import TREE, set_up

# Two columns, at x = 2 and 3, each of 4 pixels from y = 3 on.
MASK = [2 * HEIGHT + 3, 4, HEIGHT - 4, 4, HEIGHT * (WIDTH - 3) - 7]
COCO: dict[str, Any] = {
    "images": [
        {"id": 1, "file_name": "stills/push.png", "width": 200, "height": 100},
        {"id": 2, "file_name": "lift.jpg", "width": WIDTH, "height": HEIGHT},
        {"id": 3, "file_name": "another.jpg", "width": 5, "height": 5},
    ],
    "annotations": [
        {
            "id": 17,
            "image_id": 1,
            "category_id": 1,
            "bbox": [20, 30, 40, 50],
            "segmentation": [[20, 30, 60, 30, 60, 80, 20, 80]],
        },
        {"id": 18, "image_id": 1, "category_id": 2, "bbox": [90, 30, 40, 50]},
        {
            "id": 19,
            "image_id": 2,
            "category_id": 1,
            "bbox": [2, 3, 20, 30],
            "segmentation": {"counts": MASK, "size": [HEIGHT, WIDTH]},
        },
    ],
    "categories": [{"id": 1, "name": "cup"}, {"id": 2, "name": "wall"}],
}
STUDY = {
    "name": "arm",
    "title": "An arm",
    "videos": "clips",
    "things": "things.json",
    "watching": "flagged",  # nobody watches here
    "tasks": {task: {"practice": False} for task in ("describe", "segment", "ground", "check")},
}


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """A folder with a study of two videos, a still of one of them, and what is in both."""
    clip(tmp_path / "clips/push.mp4", 40)
    clip(tmp_path / "clips/lift.webm", 140)
    (tmp_path / "stills").mkdir()
    cv2.imwrite(str(tmp_path / "stills/push.png"), np.full((100, 200, 3), 90, np.uint8))
    (tmp_path / "things.json").write_text(json.dumps(COCO))
    (tmp_path / "arm.yaml").write_text(json.dumps(STUDY))
    return tmp_path


def test_an_image_is_of_the_video_with_its_name(lab: Path) -> None:
    found = read_things(lab / "things.json", {"p": lab / "clips/push.mp4", "lift": lab / "x.webm"})
    assert set(found) == {"p", "lift"}
    assert found["p"].picture == lab / "stills/push.png"
    assert found["lift"].picture is None
    cup, wall = found["p"].things
    assert (cup["id"], cup["label"], cup["box"]) == ("17", "cup", [20, 30, 40, 50])
    assert cup["polygons"] == [[[20, 30], [60, 30], [60, 80], [20, 80]]]
    assert wall["polygons"] == [[[90, 30], [130, 30], [130, 80], [90, 80]]]
    (around,) = found["lift"].things[0]["polygons"]
    assert sorted(around) == [[2, 3], [2, 6.5], [3.5, 3], [3.5, 6.5]]


def test_all_that_is_wrong_is_told_at_once(lab: Path) -> None:
    coco = copy.deepcopy(COCO)
    coco["annotations"][0]["image_id"] = 9
    coco["annotations"][1] |= {"id": 17, "category_id": 8}
    coco["annotations"][2] |= {"bbox": [2, 3, 2000, 30], "segmentation": [[1, 2, 3]]}
    (lab / "things.json").write_text(json.dumps(coco))
    with pytest.raises(FormatError) as caught:
        read_parts(lab / "arm.yaml")
    told = str(caught.value)
    for what in (
        "annotation 17: there is no image 9",
        "annotation 17: two annotations have this id",
        "annotation 17: there is no category 8",
        "annotation 19: its segmentation is no list",
        "annotation 19: its box is not in the picture",
    ):
        assert what in told


@pytest.mark.parametrize("content", ["", "[]", '{"images": []}', "\xff", '{"images": 3}'])
def test_other_files_are_refused(lab: Path, content: str) -> None:
    (lab / "things.json").write_text(content, "latin-1")
    with pytest.raises(CorpusError, match="COCO"):
        read_parts(lab / "arm.yaml")


def test_a_picture_of_another_size_and_a_video_without_things_are_named(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cv2.imwrite(str(lab / "stills/push.png"), np.zeros((10, 20, 3), np.uint8))
    check = ["annotate", "check", str(lab / "arm.yaml"), "--instance", str(lab / "instance")]
    assert run(check) == 2
    assert "has 20 by 10 pixels" in capsys.readouterr().out
    (lab / "things.json").write_text(json.dumps({**COCO, "annotations": []}))
    assert run(check) == 2
    told = capsys.readouterr()
    assert "the task ground asks about the things in videos" in told.out
    assert "nothing is marked in: 'stills/push.png', 'lift.jpg'" in told.err


def grounded_by(worker: Browser, *videos: str) -> list[str]:
    """Describe and segment each video, and ground what there is; the ids that answers name."""
    tree = to_json(parse_brackets(TREE, command="Push the cup."))
    for _ in videos:
        page = worker.lease("describe", "arm").json
        worker.answer(page["item"], described("Push the cup."))
    for _ in videos:
        page = worker.lease("segment", "arm").json
        assert worker.answer(page["item"], {"sdcs": tree}).status_code == 200
    named = []
    while (leased := worker.lease("ground", "arm")).status_code == 200:
        page = leased.json
        thing = page["payload"]["segmentation"]["objects"][0]["id"]
        node = next(str(c["node"]) for c in page["payload"]["clauses"] if c["type"] == "OBJECT")
        body = {"groundings": {node: {"objects": [thing]}}, "watched_s": 1}
        reply = worker.answer(page["item"], body)
        assert reply.status_code == 200, reply.text
        named.append(thing)
    return named


def test_boxes_for_some_videos_suffice_and_more_may_come(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    some = {**COCO, "images": COCO["images"][:1], "annotations": COCO["annotations"][:2]}
    (lab / "things.json").write_text(json.dumps(some))
    parts = read_parts(lab / "arm.yaml")
    assert parts.without_things == ["lift"]
    with set_up(lab / "arm.yaml") as app:
        worker = Browser(app, study="arm")
        assert len(grounded_by(worker, "push", "lift")) == 1
        seen = set()
        while (leased := worker.lease("check", "arm")).status_code == 200:
            page = leased.json
            seen |= {c["type"] for c in page["payload"]["clauses"]}
            verdicts = {str(c["node"]): False for c in page["payload"]["clauses"]}
            assert worker.answer(page["item"], {"verdicts": verdicts}).status_code == 200
        assert seen == {"EVENT", "OBJECT"}
    (lab / "things.json").write_text(json.dumps(COCO))
    with set_up(lab / "arm.yaml") as app:
        assert len(grounded_by(Browser(app, study="arm"))) == 1  # the other video has boxes now
    (lab / "things.json").write_text(json.dumps({**COCO, "annotations": COCO["annotations"][:1]}))
    with pytest.raises(FormatError, match="people were asked about things in the video 'lift'"):
        served_studies.put_file(open_instance(lab / "instance"), lab / "arm.yaml")
    with opened(open_instance(lab / "instance").database) as engine:  # all is as it was
        (answer,) = rows_in(engine, select(Answer).where(Answer.task == "ground").limit(1))
        page = f"/dashboard/arm/answers/{answer.id}"
        app = create_app(open_instance(lab / "instance"), engine)
        assert signed_in(app, "ada", "admin").client.get(page).status_code == 200
    capsys.readouterr()


def test_a_task_that_is_added_later_asks_about_earlier_answers(lab: Path) -> None:
    tasks = {"describe": {"practice": False}}
    (lab / "arm.yaml").write_text(json.dumps({**STUDY, "tasks": tasks}))
    with set_up(lab / "arm.yaml") as app:
        worker = Browser(app, study="arm")
        page = worker.lease("describe", "arm").json
        worker.answer(page["item"], described("Push the cup."))
        assert worker.lease("segment", "arm").status_code == 409
    (lab / "arm.yaml").write_text(json.dumps(STUDY))
    for _ in range(2):
        with set_up(lab / "arm.yaml") as app:
            assert len(rows_in(app, select(Item.id).where(Item.task == "segment"))) == 1


def test_groundings_name_the_annotations(lab: Path) -> None:
    with set_up(lab / "arm.yaml") as app:
        worker = Browser(app, study="arm")
        for _ in range(2):
            page = worker.lease("describe", "arm").json
            worker.answer(page["item"], described("Push the cup."))
        page = worker.lease("segment", "arm").json
        sdcs = to_json(parse_brackets(TREE, command="Push the cup."))
        worker.answer(page["item"], {"sdcs": sdcs})
        page = worker.lease("ground", "arm").json
        payload = page["payload"]
        assert payload["map"]["missing"]
        assert payload["map"]["robot"] is None
        things = payload["segmentation"]["objects"]
        assert "cup" not in json.dumps(things)  # no name is told
        wide = payload["segmentation"]["width"] == 200
        box = [20, 30, 40, 50] if wide else [2, 3, 20, 30]
        cup = next(one["id"] for one in things if one["box"] == box)
        (node,) = (str(c["node"]) for c in payload["clauses"] if c["type"] == "OBJECT")
        place = {"objects": [], "places": [{"xy": [[0, 0], [9, 0], [9, 9]]}]}
        refused = worker.answer(page["item"], {"groundings": {node: place}, "watched_s": 1})
        assert refused.status_code == 422
        assert "no map" in refused.text
        right = {"objects": [cup], "places": []}
        told = worker.answer(page["item"], {"groundings": {node: right}, "watched_s": 1})
        assert told.status_code == 200, told.text
        page = worker.lease("check", "arm").json  # things are drawn, too
        assert {c["type"] for c in page["payload"]["clauses"]} <= {"EVENT", "OBJECT"}
        verdicts = {str(c["node"]): False for c in page["payload"]["clauses"]}
        assert (
            worker.answer(page["item"], {"verdicts": verdicts, "watched_s": 2.0}).status_code == 200
        )
    export = ["annotate", "export", "--instance", str(lab / "instance"), "--format"]
    assert run([*export, "groundings.csv", str(lab / "g.csv")]) == 0
    (row,) = csv.DictReader(io.StringIO((lab / "g.csv").read_text()))
    assert (row["things"], row["labels"]) == ("17" if wide else "19", "cup")
    assert json.loads(row["boxes"]) == [box]
    assert run([*export, "corpus", str(lab / "corpus")]) == 0
    corpus = Corpus.load(lab / "corpus")
    assert len(corpus.commands) == 2
    (annotation,) = corpus.annotations  # the tree; a picture is no world
    assert not any(annotation.groundings)
    assert read_parts(lab / "arm.yaml").without_things == []
