"""The language model as a parser, by the command line: ``--sdc`` and a row of Table 3."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from click.testing import CliRunner

pytest.importorskip("spacy")

from corpus_tools.corpus.annotated_trees import annotated_trees
from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.eval_commands import evaluate
from eval.language_model import chat_endpoint
from eval.language_model.chat_endpoint import Endpoint, missing
from eval.language_model.model_answers import EXAMPLES, LanguageModelParser, chosen_examples
from eval.parsing.parser_registry import PARSERS, RegisteredParser
from g3.errors import CorpusError
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


@pytest.fixture(autouse=True)
def _soon(monkeypatch):
    monkeypatch.setattr(chat_endpoint, "FIRST_WAIT_S", 0.02)


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
    before, after = first.stderr.strip().splitlines()
    tokens = sum(len(m["content"]) for body in chat.bodies for m in body["messages"]) / 4
    assert before == (
        f"language model, parse: {TEXTS} requests to {chat.url} (0 replies are kept), at most "
        f"{2 * TEXTS} where replies are faulty; about {round(tokens)} tokens of prompts, "
        f"${tokens / 1e6:.4f}, and replies"
    )
    assert after.startswith(f"language model, parse: {TEXTS} requests (0 kept from before)")
    assert f"language model, parse: all {TEXTS} replies are kept" in again.stderr
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
        ('{"trees": ["PLACE(r = on, l = OBJ(f = the table))"]}', "a top-level clause is a PLACE"),
        ('{"trees": ["EVENT(f = PLACE(r = on), r = Put)"]}', "a figure is of the type PLACE"),
        (
            '{"trees": ["EVENT(r = Put, l = [OBJ(f = the cup), OBJ(f = cup)])"]}',
            "the word 'cup' is in two clauses",
        ),
        ('{"trees": ["EVENT(r = Put, l = OBJ(f = table the))"]}', "doesn't stand after the words"),
        ('{"trees": ["EVENT(r = Put)"], "taken_back": "the mug"}', "the word 'mug' is not in"),
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
    assert found["unparsed"] == 2
    for wrong in found["errors"]:
        assert (wrong["text"], wrong["predicted"]) == ("Put the cup on the table.", "")
        assert "no reply of the language model can be used: column 7" in wrong["note"]
    with chat_server(says=failing("{}", lambda _body: "{}")) as chat:
        shown = asked(*at(chat, tmp_path / "kept")[:-1])
    assert "not parsed: 2 commands" in shown.stdout
    assert shown.stdout.count("no reply of the language model can be used") == 2


@pytest.mark.parametrize(
    ("status", "body"),
    [(429, '{"error": {"message": "slow down"}}'), (500, "out of memory"), (0, "")],
)
def test_a_server_that_fails_once_is_asked_again(asked, tmp_path, status, body):
    with chat_server(
        says=as_annotated, fault=lambda count: (status, body) if count == 1 else None
    ) as chat:
        done = asked(*at(chat, tmp_path / "kept"))
    assert json.loads(done.stdout)["exact"] == 1.0
    assert sum(chat.seen.values()) == 2 * TEXTS
    used = json.loads(done.stdout)["language_model"]["parse"]
    assert used["in_doubt"] == (0 if status == 429 else TEXTS)


def test_a_server_that_is_too_slow_ends_the_run(tmp_path):
    with chat_server(says=as_annotated, delay_s=0.6) as chat:
        parser = LanguageModelParser(
            Endpoint(chat.url, "m", str(tmp_path / "kept"), timeout_s=0.2, tries=2)
        )
        with pytest.raises(CorpusError, match="no answer after 2 tries"):
            parser.parse("Go to the truck.")


def test_nothing_is_sent_that_nobody_asked_for(asked, tmp_path):
    with chat_server(says=as_annotated) as chat:
        without = asked()
        assert without.exit_code == 2
        assert "A language model needs --llm and --endpoint." in without.output
        other = asked("--parser", "verb-object", *at(chat, tmp_path))
        assert other.exit_code == 2
        assert "Say what to ask the language model for: --parser." in other.output
        trees = asked("--parser", "verb-object", "--llm-trees", "2")
        assert trees.exit_code == 2
        assert "--llm-trees is for --parser llm." in trees.output
    assert not chat.seen


def test_the_examples_of_the_prompt_are_in_the_notation():
    for example in EXAMPLES:
        text, _, trees = example.partition("\n")
        assert parse_brackets(trees, command=text)


def prompts_by_text(chat: Any) -> dict[str, str]:
    """Return the prompt that each text was sent with."""
    pairs = ([m["content"] for m in body["messages"][:2]] for body in chat.bodies)
    return {text.removeprefix("Command: "): prompt for prompt, text in pairs}


def test_the_examples_are_of_the_parts_that_are_not_tested(asked, tmp_path):
    treebank = str(tmp_path / "mine")
    given = ["--sdc", "--corpus", treebank, "--cv", "world", "--parser", "llm"]
    with chat_server(says=as_annotated) as chat:
        done = CliRunner().invoke(evaluate, [*given, *at(chat, tmp_path / "kept")])
    assert json.loads(done.stdout)["exact"] == 1.0
    prompts = prompts_by_text(chat)
    assert "Put the pallet on the truck.\nEVENT_1(r = Put, l" in prompts["Go to the table."]
    assert "Put the cup on the table.\nEVENT_1(r = Put, l" in prompts["Go to the truck."]
    for text, prompt in prompts.items():
        if text != "Good morning!":  # both worlds have it
            assert ("table" in text) != ("the table." in prompt)
            assert text not in prompt
            assert EXAMPLES[0] not in prompt


def test_examples_of_a_corpus_to_learn_from(asked, tmp_path):
    rows = [
        {"id": "1", "text": "Go.", "trees": ["EVENT(r = Go)"]},
        {"id": "2", "text": "Fly to bay 3.", "trees": ["EVENT(r = Fly)"]},
    ]
    other = tmp_path / "other"
    other.mkdir()
    (other / "trees.jsonl").write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    with chat_server(says=as_annotated) as chat:
        done = asked("--train", str(other), *at(chat, tmp_path / "kept"))
        assert json.loads(done.stdout)["train"] == "other"
        for prompt in prompts_by_text(chat).values():
            assert "Go.\nEVENT_1(r = Go)\n\nFly to bay 3.\nEVENT_1(r = Fly)\n\nReply" in prompt


def test_examples_show_many_kinds_of_fields():
    items = annotated_trees(open_corpus("warehouse"))
    examples = chosen_examples(items)
    assert examples == chosen_examples(items[::-1])
    assert len(examples) == 6
    shown = "".join(examples)
    assert all(f"{type_}_" in shown for type_ in ("EVENT", "OBJ", "PLACE", "PATH"))
    for example in examples:
        text, _, trees = example.partition("\n")
        assert parse_brackets(trees, command=text)


def test_several_trees_come_with_their_shares(tmp_path):
    lift, put = "EVENT(r = Lift, l = OBJ(f = it))", "EVENT(r = Lift it)"
    readings = [
        {"trees": [put], "share": 0.2},
        {"trees": [lift], "share": 0.5},
        {"trees": [lift], "share": 0.5},
        {"trees": [], "share": 0.8},
    ]
    with chat_server(says=lambda _body: json.dumps({"readings": readings})) as chat:
        parser = LanguageModelParser(Endpoint(chat.url, "m", str(tmp_path)), 3)
        parse = parser.parse("Lift it")
        (body,) = chat.bodies
    assert [t.probability for t in parse.trees] == [0.5, 0.1]  # of 2.0 in all
    assert [len(t.sdcs[0].landmark1) for t in parse.trees] == [1, 0]
    assert "at most 3" in body["messages"][0]["content"]
    schema = body["response_format"]["json_schema"]["schema"]
    assert set(schema["$defs"]["Reading"]["properties"]) == {"trees", "taken_back", "share"}


def test_a_parser_that_does_not_learn_takes_no_corpus_to_learn_from(asked, tmp_path):
    function = PARSERS.adding("silent", partial(RegisteredParser, "silent"))
    function(lambda text: ())
    try:
        given = ["--sdc", "--test", str(tmp_path / "mine"), "--train", "warehouse"]
        done = CliRunner().invoke(evaluate, [*given, "--parser", "silent"])
    finally:
        PARSERS.remove("silent")
    assert isinstance(done.exception, CorpusError)
    assert "the parser silent doesn't learn" in str(done.exception)


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
        done = CliRunner().invoke(evaluate, command)
        assert done.exit_code == 0, done.output
    assert sum(chat.seen.values()) == 6
    found = json.loads(done.stdout)
    right = [c["text"] for c in found["commands"]["llm-parser"] if c["correct"]]
    assert right == ["Pick up the refrigerator."]
    assert found["parsers"] == ["llm-parser"]
    assert found["parsed_by"]["llm-parser"]["prompt"].startswith("sha256:")
    assert found["language_model"]["parse"]["requests"] == 6
    trained = annotated_trees(open_corpus(train))
    texts = {one.command.text for one in trained if one.sdcs}
    for prompt in prompts_by_text(chat).values():
        shown = re.findall(r"^(.*)\nEVENT_1\(", prompt, re.MULTILINE)
        assert shown
        assert texts.issuperset(shown)
