"""The language model as a row and as the judge of Table 3, by the command line."""

import json

import pytest
from click.testing import CliRunner

from eval.cli.eval_commands import evaluate
from eval.language_model.chat_endpoint import missing
from g3.errors import CorpusError
from tests.eval.language_model.chat_server import chat_server

if missing():
    pytest.skip(missing(), allow_module_level=True)


def asked(folders, judge="automatic"):
    train, test = folders
    return ["--table", "3", "--judge", judge, "--train", train, "--test", test, "--draws", "20"]


def at(chat, folder):
    return ["--llm", "m", "--endpoint", chat.url, "--replies", str(folder), "--price", "1,10"]


@pytest.mark.slow
def test_a_row_is_asked_for_once_and_judged_as_worked_by_hand(folders, tmp_path):
    with chat_server() as chat:
        command = [*asked(folders), "--grounder", "llm", *at(chat, tmp_path), "--json"]
        command += ["--reply-form", "object"]
        first = CliRunner().invoke(evaluate, command)
        assert first.exit_code == 0, first.output
        assert sum(chat.seen.values()) == 6
        again = CliRunner().invoke(evaluate, command)
        assert sum(chat.seen.values()) == 6
    found = json.loads(first.stdout)
    told = {c["text"]: (c["correct"], c["refused"]) for c in found["commands"]["llm"]}
    assert told == {
        "Pick up the refrigerator.": (1, 0),
        "Lift the thing on the left.": (0, 1),  # it names no load
        "Put the washing machine on the trailer.": (0, 0),  # it only picks it up
        "Pick up the washer and put it down.": (0, 1),
        "Turn around and go.": (0, 1),
        "Pick up the pallet.": (1, 0),
    }
    used = found["language_model"]["plan"]
    assert (used["requests"], used["new"], used["in_doubt"]) == (6, 6, 0)
    assert used["dollars"] == pytest.approx(6 * (1000 + 20 * 10) / 1e6)
    about = found["grounders"]["llm"]
    assert (about["model"], about["seed"]) == ("m", 0)
    assert about["endpoint"] == chat.url
    assert about["prompt"].startswith("sha256:")
    pairs = {(c["one"], c["other"]) for c in found["comparisons"]}
    assert {("keywords", "llm"), ("llm", "auto")} <= pairs
    later = json.loads(again.stdout)
    assert later["rows"] == found["rows"]
    assert later["language_model"]["plan"]["kept"] == 6


@pytest.mark.slow
def test_it_judges_all_rows(folders, tmp_path):
    with chat_server() as chat:
        command = [*asked(folders, "llm"), *at(chat, tmp_path), "--most", "1"]
        done = CliRunner().invoke(evaluate, command)
        assert done.exit_code == 0, done.output
        assert set(chat.seen.values()) == {1}
    assert "all commands   (judge: llm)" in done.stdout
    assert "language model, judge: " in done.stdout
    assert "language model, plan" not in done.stdout


def test_nothing_is_asked_without_an_endpoint(folders, monkeypatch):
    monkeypatch.setenv("OPENAI_API_KEY", "a-key")
    with chat_server() as chat:
        monkeypatch.setenv("OPENAI_BASE_URL", chat.url)
        done = CliRunner().invoke(evaluate, [*asked(folders), "--grounder", "llm"])
    assert done.exit_code == 2
    assert "A language model needs --llm and --endpoint." in done.output
    assert not chat.seen


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--llm", "m"], "Give --llm and --endpoint together."),
        (["--llm", "m", "--endpoint", "http://x"], "Say what to ask the language model for"),
        (["--price", "much"], "give two numbers, such as 0.15,0.60"),
    ],
)
def test_options_that_do_not_go_together(more, said, folders):
    done = CliRunner().invoke(evaluate, [*asked(folders), *more])
    assert done.exit_code == 2
    assert said in done.output


def test_without_the_package_it_says_how_to_get_it(folders, monkeypatch, tmp_path):
    monkeypatch.setattr("eval.language_model.model_answers.missing", lambda: "openai isn't there")
    more = ["--grounder", "llm", "--llm", "m", "--endpoint", "http://127.0.0.1:9/v1"]
    done = CliRunner().invoke(evaluate, [*asked(folders), *more])
    assert isinstance(done.exception, CorpusError)
    assert "openai isn't there" in str(done.exception)
