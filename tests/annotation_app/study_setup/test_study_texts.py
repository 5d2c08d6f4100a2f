"""A study's own texts on the pages of its tasks."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import pytest
from flask import Flask
from hypothesis import given
from hypothesis import strategies as st

from annotation_app.studies.safe_markdown import to_html
from annotation_app.studies.study_file import Labels, PracticeItem, StudyConfig, TaskConfig
from annotation_app.study_setup.study_reading import read_study
from g3.errors import CorpusError
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.rendered import VIDEOS

HOSTILE = """1. **Look** <script>alert(1)</script> <img src=x onerror=alert(2)>
2. [click](javascript:alert(3)) ![see](https://example.org/a.png) [ours](https://example.org)

# Big

<div onclick="alert(4)">
"""
OWN = {
    task: TaskConfig(
        title=f"T-{task}",
        summary=f"S-{task}",
        instructions=f"{HOSTILE}\n\nOnly *{task}*",
    )
    for task in ("describe", "segment", "ground", "check", "rate")
}
ITEM = PracticeItem(video=VIDEOS[1], command="Wave.", right=(2,), good="Right so.", again="No.")


@pytest.fixture
def study() -> StudyConfig:
    tasks = OWN | {
        "rate": msgspec.structs.replace(OWN["rate"], practice_items=(ITEM, ITEM)),
        "describe": msgspec.structs.replace(OWN["describe"], answers=2),
    }
    return msgspec.structs.replace(
        STUDY,
        tasks=tasks,
        robot="arm & hand",
        statement="The {robot} did it.",
        scale=("never", "hardly", "so so", "nearly", "wholly"),
        labels=Labels(thing="Block", place="Zone", robot="the arm"),
        consent="A {robot}. <b>Bold</b>",
        attention_checks=0.0,
    )


def is_harmless(page: str) -> bool:
    return not any(
        part in page for part in ("<script>alert", "<img src=x", 'href="javascript', "<div onclick")
    )


def test_each_task_has_the_studys_texts(app: Flask) -> None:
    worker, other = Browser(app), Browser(app)
    for browser in (worker, other):
        browser.practise("describe", "segment", "ground", "check", "rate")
    other.do("describe", described())
    overview = worker.client.get("/s/tests").text
    for task in ("describe", "segment", "rate"):
        page = worker.client.get(f"/s/tests/{task}").text
        assert f"<h1>T-{task}</h1>" in page
        assert f"Only <em>{task}</em>" in page
        assert "<strong>Look</strong>" in page
        assert is_harmless(page)
        assert '<img src="https' not in page
        assert f"S-{task}" in overview
    rate = worker.client.get("/s/tests/rate").text
    assert "“The arm &amp; hand did it.”" in rate
    assert "so so" in rate
    assert "Strongly" not in rate
    assert "forklift" not in rate
    assert '"thing": "Block"' in rate


def test_texts_of_practice(app: Flask) -> None:
    worker = Browser(app)
    page = worker.client.get("/practice/ground?study=tests").text
    assert "Only <em>ground</em>" in page
    assert '"robot": "the boat"' in page
    assert is_harmless(page)
    first = worker.client.get("/practice/rate?study=tests").text
    assert '"command": "Wave."' in first
    assert "/practice/rate?study=tests\\u0026item=1" in first
    assert "arm &amp; hand" in first
    last = worker.client.get("/practice/rate?study=tests&item=1").text
    assert '"next": "/s/tests/rate"' in last
    assert worker.client.get("/practice/rate?study=tests&item=2").status_code == 404


def test_consent_is_markdown_with_the_robots_name(app: Flask) -> None:
    client = app.test_client()
    client.post("/s/tests/welcome")
    page = client.get("/s/tests/welcome").text
    assert "A arm &amp; hand. &lt;b&gt;Bold" in page


def test_without_a_studys_texts_the_apps_are_there(study: StudyConfig) -> None:
    config = StudyConfig(name="a", title="A", tasks={"rate": TaskConfig()})
    assert config.statement == "The {robot} in the video is executing the above spoken command."
    assert config.robot == "forklift"
    assert config.scale[4] == "Strongly agree"


@given(st.text(alphabet=st.sampled_from("<>[]()!*_`#&\"'=:/ \nabjavscript:onerdt"), max_size=80))
def test_no_markdown_makes_tags_that_do_something(text: str) -> None:
    import html.parser  # noqa: PLC0415

    found: list[tuple[str, list[str]]] = []

    class Reader(html.parser.HTMLParser):
        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            found.append((tag, [name for name, _ in attrs]))
            assert all(
                str(value).startswith(("http://", "https://", "mailto:"))
                for name, value in attrs
                if name == "href"
            )

    Reader().feed(str(to_html(text)))
    harmless = {"p", "em", "strong", "a", "ul", "ol", "li", "code", "pre", "blockquote", "hr", "br"}
    assert {tag for tag, _ in found} <= harmless
    assert {name for _, names in found for name in names} <= {"href", "title", "start", "class"}


def test_all_that_is_wrong_comes_at_once(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(
        """name: My Study
titel: X
tasks:
  dance: {}
  rate: {answers: 0, practise: true}
scale: [one, two]
questions:
  - {id: a}
"""
    )
    with pytest.raises(CorpusError) as error:
        read_study(file)
    told = str(error.value).splitlines()
    assert told[0].endswith("8 things are wrong:")
    assert [line.removeprefix(f"{file}:").split(": ")[0] for line in told[1:]] == [
        "1:1", "1:7", "2:8", "4:3", "5:19", "5:32", "6:8", "8:5"
    ]  # fmt: skip
    assert all(line.endswith(")") for line in told[1:])  # what to do


def test_what_fits_the_form_is_checked_all_at_once_too(tmp_path: Path) -> None:
    item = {"video": "a", "good": "Yes."}
    study = {
        "name": "x",
        "title": "X",
        "tasks": {"ground": {"practice_items": [item]}, "rate": {"practice_items": [item]}},
        "questions": [{"id": "a", "text": "A?"}, {"id": "a", "text": "B?"}],
    }
    file = tmp_path / "study.yaml"
    file.write_text(json.dumps(study))
    with pytest.raises(CorpusError) as error:
        read_study(file)
    told = str(error.value)
    assert "3 things are wrong" in told
    assert "two questions have this id" in told
    assert "there is no command to practise with (add command)" in told
