"""Trees that people made for a lab's own videos, of which no world is known, as a treebank."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.core.config import open_instance
from annotation_app.people.participants import subject_of
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened
from corpus_tools.cli.console import run
from corpus_tools.importers.treebank import read_treebank
from g3.sdc.sdc_notation import from_json, parse_brackets, to_json
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.signing_in import signed_in
from tests.annotation_app.study_setup.clips import clip
from tests.annotation_app.study_setup.test_own_videos import set_up

TREES = {
    "Land on the white van.": "EVENT(r = Land, l = PLACE(r = on, l = OBJ(f = the white van)))",
    "Fly 1.5 m up, then land.": "EVENT(r = Fly, l = PATH(r = up, l = OBJ(f = 1.5 m)))\n"
    "EVENT(r = land)",
    "The one with tires - take it.": "EVENT(r = take, l = OBJ(f = it))",
    "Put the cone on the cone.": "EVENT(r = Put, l = OBJ(f = the cone), "
    "l2 = PLACE(r = on, l = OBJ(f = the cone)))",
    "Don’t drop it, put it down.": "EVENT(r = drop, l = OBJ(f = it))\n"
    "EVENT(r = put down, l = OBJ(f = it))",
    "Über den Zaun!": "PATH(r = Über, l = OBJ(f = den Zaun))",
}
"""Commands for six videos with the trees that most people make, or the adjudicator."""
DISPUTED = "Put the cone on the cone."


def tree(text: str, notation: str) -> list[dict[str, object]]:
    return to_json(parse_brackets(notation, command=text))


@pytest.fixture
def study(tmp_path: Path) -> Path:
    for number in range(len(TREES)):
        clip(tmp_path / f"clips/fly-{number}.mp4", 40 + 20 * number)
    segment = {"practice": False, "answers": 3, "adoption": "majority"}
    content = {
        "name": "drone",
        "title": "A drone",
        "videos": "clips",
        "watching": "flagged",
        "tasks": {"describe": {"practice": False}, "segment": segment},
    }
    file = tmp_path / "drone.yaml"
    file.write_text(json.dumps(content))
    return file


def annotate(app: Flask) -> set[str]:
    """Two people describe, three segment, an adjudicator decides; the names of the two."""
    people = [Browser(app, study="drone") for _ in range(3)]
    for number, text in enumerate(TREES):
        writer = people[number % 2]
        page = writer.lease("describe", "drone").json
        assert writer.answer(page["item"], described(text)).status_code == 200
    for number, person in enumerate(people):
        for _ in TREES:
            page = person.lease("segment", "drone").json
            text = page["payload"]["command"]
            word = text.split()[number].strip(".,")
            is_other = number == 1 or text == DISPUTED
            sdcs = tree(text, f"OBJ(f = {word})" if is_other else TREES[text])
            assert person.answer(page["item"], {"sdcs": sdcs}).status_code == 200
    return {subject_of(person.person) for person in people[:2]}


def test_trees_of_own_videos_go_out_and_in_again_as_they_are(study: Path, tmp_path: Path) -> None:
    instance, out = tmp_path / "instance", tmp_path / "out"
    with set_up(study) as app:
        writers = annotate(app)
        judge = signed_in(app, "judy", "adjudicator")
        (dispute,) = judge.client.get("/api/dashboard/studies/drone/queue").json["data"]
        chosen = {"sdcs": tree(DISPUTED, TREES[DISPUTED])}
        assert judge.adjudicate(dispute["item"], chosen).status_code == 200
        reply = judge.client.get("/dashboard/drone/export/treebank")
        assert 'filename="drone-treebank.zip"' in reply.headers["Content-Disposition"]
    zipfile.ZipFile(io.BytesIO(reply.data)).extractall(tmp_path)
    export = ["annotate", "export", "--instance", str(instance), "--format"]
    assert run([*export, "treebank", str(out)]) == 0
    assert {file.name: file.read_bytes() for file in out.iterdir()} == {
        file.name: file.read_bytes() for file in (tmp_path / "drone").iterdir()
    }
    found = read_treebank(out)
    assert {one.text: to_json(one.trees) for one in found} == {
        text: tree(text, notation) for text, notation in TREES.items()
    }
    assert {one.person for one in found} == writers
    assert "drone" in (out / "dataset.yaml").read_text()

    assert run(["import", "treebank", str(out), "--out", str(tmp_path / "imported")]) == 0
    assert run(["train", "parser", "--corpus", str(out), "--out", str(tmp_path / "p.npz")]) == 0
    assert run([*export, "corpus", str(tmp_path / "corpus")]) == 0
    for corpus in ("imported", "corpus"):
        assert run(["corpus", "validate", str(tmp_path / corpus)]) == 0
        again = tmp_path / f"{corpus}-again"
        to = ["--to", "treebank", "--out", str(again)]
        assert run(["corpus", "export", str(tmp_path / corpus), *to]) == 0
        assert read_treebank(again) == found

    other = tmp_path / "other"
    assert run(["annotate", "import", str(out), "--instance", str(other)]) == 0
    config = replace(open_instance(other), rate_limits=False)
    with opened(config.database) as engine:
        expert = Browser(create_app(config, engine), "annotator", "drone")
        for one in found:
            page = expert.lease("segment", "drone").json
            suggested = page["payload"]["suggestion"]
            assert (page["payload"]["command"], from_json(suggested)) == (one.text, one.trees)
            assert expert.answer(page["item"], {"sdcs": suggested}).status_code == 200
    export[export.index(str(instance))] = str(other)
    assert run([*export, "treebank", str(tmp_path / "third")]) == 0
    assert read_treebank(tmp_path / "third") == found
