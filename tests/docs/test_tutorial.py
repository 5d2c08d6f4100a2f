"""The tutorial, step by step as it stands there, in an empty folder."""

from __future__ import annotations

import re
import shlex
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database, reading
from annotation_app.store.models import Item
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser, described, engine_of
from tests.annotation_app.real_server import started
from tests.docs.blocks import ROOT, shown

PAGE = ROOT / "docs/tutorial.md"
FILE = re.compile(r"`([\w/-]+\.yaml)`:\n\n```yaml\n(.*?)```", re.DOTALL)
SMALL = ["--quality", "draft", "--size", "64x64", "--fps", "2"]

COMMANDS = {
    "put_tires_on_trailer": (
        "Put the tires on the trailer",
        "EVENT(r = Put, l = OBJ(f = the tires), l2 = PLACE(r = on, l = OBJ(f = the trailer)))",
    ),
    "lift_boxes": ("Pick up the boxes", "EVENT(r = Pick up, l = OBJ(f = the boxes))"),
    "drive_to_crate": (
        "Drive to the crate",
        "EVENT(r = Drive, l = PATH(r = to, l = OBJ(f = the crate)))",
    ),
    "drive_to_truck": (
        "Go over to the truck",
        "EVENT(r = Go, l = PATH(r = over to, l = OBJ(f = the truck)))",
    ),
}
"""What people type for each video, and its clauses."""
TREES = dict(COMMANDS.values())
PEOPLE = 5


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def steps(begin: str) -> list[list[str]]:
    """The arguments of the tutorial's calls of ``ct`` that begin in some way."""
    calls = [c for s in shown() if s.page == "docs/tutorial.md" for c in s.calls]
    chosen = [call for call in calls if shlex.join(call).startswith(begin)]
    assert chosen, f"the tutorial has no ct {begin}"
    return chosen


@pytest.mark.slow
def test_it_works_as_written(
    folder: Path, trained: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "afternoon" / "scenarios").mkdir(parents=True)
    monkeypatch.chdir(folder / "afternoon")
    for name, content in FILE.findall(PAGE.read_text()):
        Path(name).write_text(content)
    for call in steps("scenarios"):
        assert run(call) == 0

    (render,) = steps("render-videos")
    files = sorted(map(str, Path("scenarios").glob("*.yaml")))
    assert [Path(name).stem for name in files] == sorted(COMMANDS)
    assert run([*(w for word in render for w in (files if "*" in word else [word])), *SMALL]) == 0

    serve_for_a_moment(steps("annotate my-study.yaml")[0])
    annotate()

    for begin in ("annotate export", "corpus", "train", "eval table1 --corpus"):
        for call in steps(begin):
            assert run(call) == 0, call
    corpus = Corpus.load(Path("my-corpus"))
    assert len(corpus.commands) == PEOPLE * len(COMMANDS)
    assert {a.source for a in corpus.annotations} == {"positive", "random"}

    small = ["--model", str(trained("one-scenario")), "--plan-only"]
    for call in steps("follow"):
        wanted = call[: call.index("--video")] if "--video" in call else call
        assert run([*wanted, *small]) == 0


def serve_for_a_moment(call: list[str]) -> None:
    """Start the server; end it with Ctrl-C when it has told its addresses."""
    with started(Path("log"), *call, "--port", "0") as server:
        assert server.end(signal.SIGINT) == 0


def annotate() -> None:
    """Five people type commands, one of them does the rest."""
    engine = open_database(open_instance(Path("annotation")).database)
    app = create_app(open_instance(Path("annotation")), engine)
    people = [Browser(app, study="my-study") for _ in range(PEOPLE)]
    for person in people:
        for _ in COMMANDS:
            person.send("POST", "/api/practice/describe", {})
            page = person.lease("describe", "my-study").json
            text, _ = COMMANDS[subject(app, page["item"])]
            body = described(text) | person.watched(page)
            assert person.answer(page["item"], body).status_code == 200
    annotator = people[0]
    for task in ("segment", "ground", "check"):
        annotator.send("POST", f"/api/practice/{task}", {})
        while (response := annotator.lease(task, "my-study")).status_code == 200:
            page = response.json
            body = ANSWERS[task](page["payload"])
            if task != "segment":
                body |= annotator.watched(page)
            answered = annotator.answer(page["item"], body)
            assert answered.status_code == 200, answered.text
    engine.dispose()


def subject(app, item: str) -> str:
    """Which video an item is about; people see it."""
    with reading(engine_of(app)) as session:
        found = session.get(Item, item)
        assert found is not None
        return str(found.payload["video"])


def segmented(payload) -> dict[str, object]:
    text = payload["command"]
    return {"sdcs": to_json(parse_brackets(TREES[text], command=text))}


def grounded(payload) -> dict[str, object]:
    """Some thing for each clause: it is the steps that are tried, not the annotator."""
    thing = payload["map"]["objects"][0]["id"]
    nodes = [c["node"] for c in payload["clauses"] if c["type"] in ("OBJECT", "PLACE")]
    return {"groundings": {str(node): {"objects": [thing]} for node in nodes}}


def checked(payload) -> dict[str, object]:
    return {"verdicts": {str(clause["node"]): False for clause in payload["clauses"]}}


ANSWERS = {"segment": segmented, "ground": grounded, "check": checked}
