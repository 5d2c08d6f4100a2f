"""A corpus of random tasks, which has no clauses yet, goes through the app and back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import validate
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser
from tests.annotation_app.rendered import render_contexts
from tests.corpus_tools.importers import random_tasks as made
from tests.tiny_corpus import tiny_corpus

TREE = "EVENT(r = Pick up, l = OBJ(f = the fridge))"


def test_commands_without_clauses_can_be_annotated_and_exported(tmp_path: Path) -> None:
    group = tmp_path / "forklift.automatic.v1"
    for name in ("2011_1_manip", "2011_2_manip"):
        made.put_world(group, name)
    folder, instance, out = tmp_path / "corpus", tmp_path / "instance", tmp_path / "out"
    assert run(["import", "slu-core", str(group), "--part", "automatic", "--out", str(folder)]) == 0
    corpus = Corpus.load(folder)
    videos = tmp_path / "videos"
    draft = ["--quality", "draft", "--size", "320x240", "--out", str(videos)]
    assert run(["render-videos", "--corpus", str(folder), *draft]) == 0
    command = ["annotate", "import", str(folder), "--videos", str(videos)]
    assert run([*command, "--instance", str(instance), "--study", "tasks"]) == 0

    config = open_instance(instance)
    engine = open_database(config.database)
    expert = Browser(create_app(config, engine), "annotator", "tasks")
    page = expert.lease("segment", "tasks").json
    text = page["payload"]["command"]
    assert text == "Pick up the fridge."
    answer = expert.answer(page["item"], {"sdcs": to_json(parse_brackets(TREE, command=text))})
    assert answer.status_code == 200, answer.text
    page = expert.lease("ground", "tasks").json
    (node,) = (c["node"] for c in page["payload"]["clauses"] if c["type"] == "OBJECT")
    thing = page["payload"]["map"]["objects"][0]
    answer = expert.answer(page["item"], {"groundings": {str(node): {"objects": [thing["id"]]}}})
    assert answer.status_code == 200, answer.text
    engine.dispose()

    assert run(["annotate", "export", str(out), "--instance", str(instance)]) == 0
    assert validate(out) == []
    exported = Corpus.load(out)
    assert exported.commands == corpus.commands
    assert exported.outcomes == corpus.outcomes
    assert exported.contexts == corpus.contexts
    (annotation,) = (a for a in exported.annotations if a.source == "positive")
    # No log tells how the robot moved, so the EVENT has no grounding, rather than a wrong one.
    assert [len(group) for group in annotation.groundings] == [0, 0, 1]
    assert annotation.groundings[2][0] in annotation.context.objects
    assert annotation.correct == (None, None, True)


def test_a_command_of_several_contexts_has_no_video(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    corpus = tiny_corpus()
    elsewhere = list(corpus.contexts.values())[-1]
    first = corpus.annotations[0]
    again = replace(first, id="again", context=elsewhere, groundings=((),) * len(first.groundings))
    both = Corpus.build(
        "both",
        contexts=corpus.contexts.values(),
        commands=corpus.commands.values(),
        annotations=[*corpus.annotations, again],
    )
    both.save(tmp_path / "both")
    videos = render_contexts(tmp_path / "videos", corpus)
    command = ["annotate", "import", str(tmp_path / "both"), "--videos", str(videos)]
    assert run([*command, "--instance", str(tmp_path / "instance")]) == 2
    assert f"{first.command.id}: the command is annotated in several" in capsys.readouterr().err
