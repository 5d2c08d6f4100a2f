"""The language model as a parser, by the command line: ``--sdc`` and a row of Table 3."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from click.testing import CliRunner

pytest.importorskip("spacy")

from eval.cli.eval_commands import evaluate
from eval.language_model.chat_endpoint import missing
from eval.language_model.model_answers import PARSING
from g3.sdc.sdc_notation import parse_brackets
from tests.eval.language_model.chat_server import chat_server
from tests.small_treebank import tree_rows, write_treebank

if missing():
    pytest.skip(missing(), allow_module_level=True)

RIGHT = {
    row["text"]: {"trees": row["trees"], "taken_back": row.get("taken_back", "")}
    for row in tree_rows()
}
TEXTS = len(RIGHT)


def as_annotated(body: dict[str, Any]) -> str:
    text = body["messages"][1]["content"].removeprefix("Command: ")
    return json.dumps(RIGHT[text])


def failing(first: str, then: Callable[[dict[str, Any]], str]) -> Callable[[dict[str, Any]], str]:
    """Say something that can't be used about one command, and something else when told."""

    def says(body: dict[str, Any]) -> str:
        about = body["messages"][1]["content"]
        if about != "Command: Put the cup on the table.":
            return as_annotated(body)
        return first if len(body["messages"]) == 2 else then(body)

    return says


@pytest.fixture
def asked(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    treebank = write_treebank(tmp_path / "mine")

    def command(*more: str) -> Any:
        given = ["--sdc", "--test", str(treebank), "--parser", "llm", *more]
        return CliRunner().invoke(evaluate, given)

    return command


def at(chat, folder):
    return ["--llm", "m", "--endpoint", chat.url, "--replies", str(folder), "--json"]


def test_each_text_is_sent_once_and_its_trees_compared(asked, tmp_path):
    with chat_server(says=as_annotated) as chat:
        first = asked(*at(chat, tmp_path / "kept"), "--price", "1,10")
        assert first.exit_code == 0, first.output
        assert len(chat.seen) == sum(chat.seen.values()) == TEXTS
        again = asked(*at(chat, tmp_path / "kept"))
        assert sum(chat.seen.values()) == TEXTS
    found = json.loads(first.stdout)
    assert (found["commands"], found["exact"], found["typed_f"]) == (16, 1.0, 1.0)
    assert found["parser"] == "llm-parser"
    assert found["parsed_by"]["model"] == "m"
    used = found["language_model"]["parse"]
    assert (used["requests"], used["new"]) == (TEXTS, TEXTS)
    assert used["dollars"] == pytest.approx(TEXTS * (1000 + 20 * 10) / 1e6)
    assert f"language model, parse: {TEXTS} requests" in first.stderr
    assert json.loads(again.stdout)["language_model"]["parse"]["kept"] == TEXTS
    schema = chat.bodies[0]["response_format"]["json_schema"]
    assert schema["name"] == "parse"
    assert schema["schema"]["required"] == ["trees"]


@pytest.mark.parametrize(
    ("first", "told"),
    [
        ('{"trees": ["EVENT(r = Put, l = the cup)"]}', "expected a clause or a list of clauses"),
        ('{"trees": ["EVENT(r = Put, l = OBJ(f = the mug))"]}', "the word 'mug' is not in the"),
        ("Put: the cup.", "malformed"),
    ],
)
def test_what_leaves_the_grammar_is_repaired_once(asked, tmp_path, first, told):
    with chat_server(says=failing(first, as_annotated)) as chat:
        done = asked(*at(chat, tmp_path / "kept"))
    assert json.loads(done.stdout)["exact"] == 1.0
    assert sum(chat.seen.values()) == TEXTS + 1
    (repair,) = (body for body in chat.bodies if len(body["messages"]) > 2)
    assert repair["messages"][2] == {"role": "assistant", "content": first}
    assert told in repair["messages"][3]["content"]


def test_what_stays_wrong_has_no_trees(asked, tmp_path):
    with chat_server(says=failing("{}", lambda _body: '{"trees": ["EVENT("]}')) as chat:
        done = asked(*at(chat, tmp_path / "kept"))
    found = json.loads(done.stdout)
    assert sum(chat.seen.values()) == TEXTS + 1  # it isn't asked a third time
    assert [(wrong["text"], wrong["predicted"]) for wrong in found["errors"]] == [
        ("Put the cup on the table.", "")
    ] * 2


def test_nothing_is_sent_that_nobody_asked_for(asked, tmp_path):
    with chat_server(says=as_annotated) as chat:
        without = asked()
        assert without.exit_code == 2
        assert "A language model needs --llm and --endpoint." in without.output
        other = asked("--parser", "verb-object", *at(chat, tmp_path))
        assert other.exit_code == 2
        assert "Say what to ask the language model for: --parser." in other.output
    assert not chat.seen


def test_the_examples_of_the_prompt_are_in_the_notation():
    examples = [part.splitlines() for part in PARSING.split("\n\n")[1:-1]]
    for text, *trees in examples:
        assert parse_brackets("\n".join(trees), command=text)
    assert len(examples) == 3


@pytest.mark.slow
def test_a_row_of_table_3_is_the_model_with_its_clauses(folders, tmp_path):
    def says(body: dict[str, Any]) -> str:
        text = body["messages"][1]["content"]
        tree = "EVENT(r = Pick up, l = OBJ(f = the refrigerator))"
        return json.dumps({"trees": [tree] if "refrigerator" in text else []})

    train, test = folders
    given = ["--table", "3", "--judge", "automatic", "--train", train, "--test", test]
    with chat_server(says=says) as chat:
        command = [*given, "--draws", "20", "--parser", "llm", *at(chat, tmp_path / "kept")]
        done = CliRunner().invoke(evaluate, [*command, "--jobs", "2"])
        assert done.exit_code == 0, done.output
    assert sum(chat.seen.values()) == 6
    found = json.loads(done.stdout)
    right = [c["text"] for c in found["commands"]["llm-parser"] if c["correct"]]
    assert right == ["Pick up the refrigerator."]
    assert found["parsers"] == ["llm-parser"]
    assert found["parsed_by"]["llm-parser"]["prompt"].startswith("sha256:")
    assert found["language_model"]["parse"]["requests"] == 6
