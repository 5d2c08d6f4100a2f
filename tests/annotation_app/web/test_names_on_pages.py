"""Pages of every kind of study: accessible, without an error, and workers need not scroll.

Researchers' pages name people and things.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from flask import Flask
from playwright.sync_api import Browser as Chromium
from playwright.sync_api import Page, expect
from sqlalchemy import select

from annotation_app.store.models import Item, Person
from corpus_tools.importers.authored.bundled import open_corpus
from docs.example_study import SCENARIOS, example
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser, described, rows_in
from tests.annotation_app.in_browser import (
    ANY,
    errors_of,
    out_of_sight,
    serving,
    sign_in,
    violations,
)
from tests.annotation_app.pages.films import film
from tests.annotation_app.pages.test_fold import NEEDED
from tests.annotation_app.signing_in import signed_in
from tests.annotation_app.study_setup.clips import HEIGHT, WIDTH, clip
from tests.annotation_app.study_setup.test_own_videos import TREE, set_up

pytestmark = pytest.mark.slow

HASH = re.compile(r"\b[0-9a-f]{10,64}\b")
RAW = re.compile(r"watched_s|played_to_end|\b1[0-9]{9}\.[0-9]+|None\b|undefined|\[object")
TEXT_AND_LINKS = """[
  document.querySelector("main").innerText,
  [...document.querySelectorAll("a[href]")].map(link => link.href),
]"""
FILES = re.compile(r"/export/|/video/\d|/upload/|/queue/next|logout")
STUDY = {
    "name": "arm",
    "title": "An arm",
    "videos": "clips",
    "watching": "flagged",
    "tasks": {
        task: {"practice": False, "answers": 2 if task in ("segment", "ground") else 1}
        for task in (
            "describe",
            "segment",
            "ground",
            "check",
            "rate",
            "subtasks",
            "moments",
            "mark",
        )
    },
}
COCO = {
    "images": [{"id": 1, "file_name": "push.png", "width": WIDTH, "height": HEIGHT}],
    "annotations": [
        {"id": 70017 + n, "image_id": 1, "category_id": n % 2, "bbox": [5 + 12 * n, 5, 10, 20]}
        for n in range(3)
    ],
    "categories": [{"id": 0, "name": "red barrel"}, {"id": 1, "name": "van"}],
}


def body_of(task: str, payload: dict[str, Any], number: int, thing: str) -> dict[str, Any]:
    """An answer of the first or the second person, to describe about a thing."""
    clauses = payload.get("clauses", ())
    if task == "ground":
        chosen = payload["segmentation"]["objects"][number]["id"]
        nodes = [str(one["node"]) for one in clauses if one["type"] == "OBJECT"]
        return {"groundings": {node: {"objects": [chosen]} for node in nodes}, "watched_s": 4}
    steps = [{"start_s": 0, "text": "Push"}]
    told = payload.get("command") or f"Push the {thing}."
    tree = TREE.replace("cup", told.rstrip(".").split()[-1])
    return {
        "describe": described(told),
        "segment": {"sdcs": to_json(parse_brackets(tree, command=told))},
        "check": {"verdicts": {str(one["node"]): "cant_tell" for one in clauses}},
        "rate": {"rating": 4, "watched_s": 1},
        "subtasks": {"subtasks": steps, "played_to_end": True},
        "moments": {"moments": [{"style": "interjection", "time_s": 0.2, "text": "Go on"}]},
        "mark": {"success": "partly", "quality": 3, "moment_s": 0.1},
        "correct": {"verdict": "right"},
    }[task]


def work(app: Flask, page: Page, site: str, study: str, tasks: Iterable[str]) -> list[str]:
    """Two people answer all there is, ground differently, and report a problem.

    One of them looks at each task's page before: returns what axe finds there, and what is needed
    and not in sight.
    """
    people = [Browser(app, study=study) for _ in range(2)]
    things, wrong = cycle(("cup", "lid")), []
    for task in tasks:
        for person in people:
            sign_in(page.context, person, site)
            page.goto(f"{site}/s/{study}/{task}")
            if page.locator("#submit").count():  # nobody rates their own commands
                break
        expect(page.locator("#submit")).to_be_enabled()
        wrong += violations(page, ANY)
        wrong += out_of_sight(page, *(one for one in NEEDED[task] if one != ".map"))
        for number, person in enumerate(people):
            while (leased := person.lease(task, study)).status_code == 200:
                given = leased.json
                body = body_of(task, given["payload"], number, next(things))
                reply = person.answer(given["item"], body)
                assert reply.status_code == 200, (task, reply.text)
                person.note(given["item"], "flag", "It is dark.")
    return wrong


Study: TypeAlias = tuple[Flask, str, Iterable[str], set[str]]
"""An app with a study: its name, the tasks that nobody has done yet, and ids of its things."""


@contextmanager
def own(folder: Path, things: str = "") -> Iterator[Study]:
    clip(folder / "clips/push.mp4", 40)
    clip(folder / "clips/lift.webm", 140)
    tasks = {name: of for name, of in STUDY["tasks"].items() if things or name != "ground"}
    study = {**STUDY, "tasks": tasks, **({"things": things} if things else {})}
    if things:
        (folder / things).write_text(json.dumps(COCO))
    (folder / "arm.yaml").write_text(json.dumps(study))
    with set_up(folder / "arm.yaml") as app:
        yield app, "arm", tasks, {str(one["id"]) for one in COCO["annotations"]}


@contextmanager
def episodes(folder: Path) -> Iterator[Study]:
    pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
    from tests.annotation_app.study_setup.test_robot_episodes import study_of  # noqa: PLC0415

    names = [name for name in STUDY["tasks"] if name not in ("ground", "check")]
    tasks = {name: {"practice": False, "answers": 1} for name in (*names, "correct")}
    file = study_of(folder, name="arm", title="An arm", watching="flagged", tasks=tasks)
    with set_up(file) as app:
        yield app, "arm", tasks, set()


@contextmanager
def scenes(folder: Path) -> Iterator[Study]:
    contexts = open_corpus("warehouse").contexts
    films = film(folder / "films", SCENARIOS, lambda name, _number: contexts[name])
    (folder / "example").mkdir()
    with example(folder / "example", films) as made:
        ids = {thing.id for name in SCENARIOS for thing in contexts[name].objects} - {"forklift"}
        yield made.app, made.words["<study_name>"], (), ids


@pytest.mark.parametrize("kind", ["boxes for some", "no boxes", "episodes", "scenes"])
def test_no_page_has_an_error_or_a_raw_id(kind: str, tmp_path: Path, chromium: Chromium) -> None:
    made = {
        "boxes for some": lambda: own(tmp_path, "boxes.json"),
        "no boxes": lambda: own(tmp_path),
        "episodes": lambda: episodes(tmp_path),
        "scenes": lambda: scenes(tmp_path),
    }[kind]()
    with made as (app, study, tasks, things), serving(app) as site:
        size = {"width": 1280, "height": 800}
        page = chromium.new_context(viewport=size, reduced_motion="reduce").new_page()
        page.add_init_script(Axe().axe_script)
        errors = errors_of(page)
        wrong = work(app, page, site, study, tasks)
        sign_in(page.context, signed_in(app, "walker", "admin"), site)
        hidden = {*rows_in(app, select(Item.id)), *rows_in(app, select(Person.id))}
        hidden |= {one[:12] for one in rows_in(app, select(Person.external_hash))}
        raw: list[str] = []
        todo, seen = [f"/dashboard/{study}", f"/admin/studies/{study}/videos"], set()
        kinds: set[str] = set()
        while todo:
            path = todo.pop()
            seen.add(path)
            page.goto(site + path)
            if (like := re.sub(r"/[^/]*\d[^/]*|[?].*", "/*", path)) not in kinds:
                kinds.add(like)
                wrong += violations(page, ANY)
            text, links = page.evaluate(TEXT_AND_LINKS)
            words = set(re.findall(r"[\w-]+", text))
            raw += [f"{path}: {word}" for word in sorted(words & (hidden | things))]
            raw += [f"{path}: {word}" for word in RAW.findall(text) + HASH.findall(text)]
            for link in map(urlsplit, links):
                whole = f"{link.path}?{link.query}" if link.query else link.path
                is_ours = re.match(rf"/(dashboard|admin/studies)/{study}\b", link.path)
                if is_ours and whole not in seen and not FILES.search(link.path):
                    todo.append(whole)
            todo = list(dict.fromkeys(todo))
        assert raw == []
        assert wrong == []
        # The page with what stops a study from being changed is refused.
        assert [error for error in errors if "422" not in error] == []
        assert len(seen) > 15
        if kind == "boxes for some":
            check_labels(page, site, [path for path in seen if re.search("/queue/[^/]+$", path)])


def check_labels(page: Page, site: str, disputes: list[str]) -> None:
    """Things are numbered in the picture, and are told by number and name."""
    page.goto(site + disputes[0])
    chosen = sorted(page.locator("dd b[data-shown]").all_inner_texts())
    assert len(set(chosen)) == 2
    assert sorted(page.locator(".frame svg text").all_text_contents()) == chosen
    for told in page.locator("dd mark").all_inner_texts():
        assert re.fullmatch(r"\d (red barrel [12]|van)", told), told
