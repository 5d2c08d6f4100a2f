"""Asking a language model: what is sent, kept, sent again and paid, by a real server."""

import json
import time

import pytest

from eval.judging.execution import planned
from eval.judging.judge_registry import JudgedPlan
from eval.language_model import chat_endpoint
from eval.language_model.chat_endpoint import KEY_VARIABLE, Endpoint, missing, usage
from eval.language_model.model_answers import LanguageModelGrounder, LanguageModelJudge, json_in
from g3.actions.action_kinds import KINDS
from g3.errors import CorpusError
from tests.eval.language_model.asking_program import ask, tasks
from tests.eval.language_model.chat_server import answer, chat_server
from tests.processes import forked

if missing():
    pytest.skip(missing(), allow_module_level=True)


@pytest.fixture(autouse=True)
def _soon(monkeypatch):
    monkeypatch.setattr(chat_endpoint, "FIRST_WAIT_S", 0.02)


def grounder(chat, folder, **settings):
    return LanguageModelGrounder(Endpoint(chat.url, "test-model", str(folder), **settings))


def nothing(*told):
    """No progress is shown."""


def test_a_plan_is_asked_for_with_the_world_the_seed_and_the_form(tmp_path, monkeypatch):
    monkeypatch.setenv(KEY_VARIABLE, "secret-key")
    with chat_server() as chat:
        (task,) = tasks(1)
        made = grounder(chat, tmp_path, seed=7).propose(task)
    assert [a.object_id for a in made.actions] == ["p1"]
    assert (made.probability, made.note) == (0.75, "it is named")
    (body,) = chat.bodies
    assert (body["model"], body["seed"], body["temperature"]) == ("test-model", 7, 0.0)
    form = body["response_format"]["json_schema"]["schema"]
    assert form["type"] == "object"
    assert set(form["properties"]) == {"actions", "probability", "reason"}
    assert form["$defs"]["PlanStep"]["properties"]["action"]["enum"] == list(KINDS)
    told, asked = (message["content"] for message in body["messages"])
    assert '- "drive between": (target, two of them)' in told
    assert '"labels":["tire","pallet"]' in asked
    assert "Lift the tire pallet, 0." in asked
    assert "c0" not in asked  # ids of commands may tell what the video shows
    assert chat.headers[0]["authorization"] == "Bearer secret-key"
    kept = "".join(p.read_text() for p in tmp_path.rglob("*.json"))
    assert "Lift the tire pallet, 0." in kept
    assert '"seed": 7' in kept
    assert '"fp_test"' in kept
    assert "secret-key" not in kept


@pytest.mark.parametrize(("form", "kind"), [("object", "json_object"), ("none", None)])
def test_servers_that_know_no_schemas_are_asked_in_another_form(form, kind, tmp_path):
    with chat_server() as chat:
        (task,) = tasks(1)
        made = grounder(chat, tmp_path, form=form).propose(task)
    assert [a.object_id for a in made.actions] == ["p1"]
    told = chat.bodies[0].get("response_format")
    assert (told and told["type"]) == kind
    if told:
        assert set(told["schema"]["properties"]) == {"actions", "probability", "reason"}


def test_nothing_is_sent_twice(tmp_path):
    with chat_server() as chat:
        for _ in range(3):
            grounder(chat, tmp_path).prepare(tasks(5), nothing)
        same = [tasks(1)[0]] * 20
        grounder(chat, tmp_path / "other", at_once=8).prepare(same, nothing)
    counts = sorted(chat.seen.values())
    assert counts == [1, 1, 1, 1, 2]  # the first one for another folder, too


@pytest.mark.parametrize("change", [{"seed": 1}, {"temperature": 0.5}, {"model": "other"}])
def test_what_decides_of_a_reply_asks_anew(change, tmp_path):
    (task,) = tasks(1)
    with chat_server() as chat:
        first = Endpoint(chat.url, "test-model", str(tmp_path))
        LanguageModelGrounder(first).propose(task)
        settings = {"model": "test-model", **change}
        LanguageModelGrounder(Endpoint(chat.url, folder=str(tmp_path), **settings)).propose(task)
        assert len(chat.seen) == 2


def test_eight_requests_are_under_way_at_once(tmp_path):
    with chat_server(together=8) as chat:
        grounder(chat, tmp_path, at_once=8).prepare(tasks(40), nothing)
    assert chat.most_at_once == 8
    assert set(chat.seen.values()) == {1}
    assert len(chat.seen) == 40


@pytest.mark.parametrize(
    ("status", "body", "in_doubt"),
    [
        (429, '{"error": {"message": "slow down"}}', 0),  # whoever has to wait pays nothing
        (500, '{"error": {"message": "out of memory"}}', 2),
        (503, "<html>down</html>", 2),
        (0, "", 2),  # it hangs up
    ],
)
def test_what_comes_to_nothing_is_sent_again(status, body, in_doubt, tmp_path):
    def fault(count):
        return (status, body) if count <= 2 else None

    with chat_server(fault=fault) as chat:
        own = grounder(chat, tmp_path)
        assert own.propose(tasks(1)[0]).actions
        assert list(chat.seen.values()) == [3]
        told = usage(own.endpoint, "plan")
    assert (told["requests"], told["sent"], told["in_doubt"]) == (1, 3, in_doubt)
    keys = {h["idempotency-key"] for h in chat.headers}
    assert len(keys) == 1


def test_who_answers_too_late_may_have_been_paid(tmp_path):
    with chat_server(delay_s=0.6) as chat:
        own = grounder(chat, tmp_path, timeout_s=0.2, tries=2)
        with pytest.raises(CorpusError, match="no answer after 2 tries") as error:
            own.propose(tasks(1)[0])
        assert "replies that came are kept" in error.value.fix
        chat.delay_s = 0.0
        assert own.propose(tasks(1)[0]).actions
        told = usage(own.endpoint, "plan")
    assert (told["sent"], told["in_doubt"]) == (3, 2)


def test_a_server_that_is_not_there_costs_nothing(tmp_path):
    with chat_server() as chat:
        pass
    own = grounder(chat, tmp_path, tries=2)
    with pytest.raises(CorpusError, match="no answer after 2 tries") as error:
        own.prepare(tasks(3), nothing)
    assert error.value.where == chat.url
    notes = [json.loads(path.read_text()) for path in tmp_path.rglob("*.asked")]
    assert notes
    assert all(note["sent"] == note["unpaid"] for note in notes)


@pytest.mark.parametrize("status", [400, 401, 404, 422])
def test_what_is_refused_is_not_sent_again(status, tmp_path):
    with chat_server(fault=lambda _: (status, '{"error": {"message": "no such model"}}')) as chat:
        with pytest.raises(CorpusError, match=f"refuses the request: {status} no such model"):
            grounder(chat, tmp_path).propose(tasks(1)[0])
        assert list(chat.seen.values()) == [1]


@pytest.mark.parametrize(
    "said",
    [
        "I can't do that.",
        '{"actions": [{"action": "fly"}]}',
        '{"actions": [{"action": "pick up", "object": "moon"}]}',
        '{"actions": [{"action": "put down", "at": [1, 2]}]}',
        '{"actions": "pick up"}',
        '{"actions": [], "probability": 7}',
        '{"actions": [',
        "",
    ],
)
def test_what_cannot_be_used_is_told_and_asked_for_again(said, tmp_path):
    def says(body):
        return said if len(body["messages"]) == 2 else answer(body)

    with chat_server(says=says) as chat:
        made = grounder(chat, tmp_path).propose(tasks(1)[0])
        again = grounder(chat, tmp_path).propose(tasks(1)[0])
        assert made == again
        assert sorted(chat.seen.values()) == [1, 1]  # bad replies are kept too: they were paid
    assert [a.object_id for a in made.actions] == ["p1"]
    last = chat.bodies[-1]["messages"]
    assert last[2] == {"role": "assistant", "content": said}
    assert "can't be used" in last[3]["content"]


def test_who_never_says_anything_useful_refuses(tmp_path):
    with chat_server(says=lambda body: "Hm.") as chat:
        made = grounder(chat, tmp_path).propose(tasks(1)[0])
        assert len(chat.seen) == 3
    assert made.actions == ()
    assert made.note.startswith("no reply of the language model can be used")


def test_what_a_run_took_is_counted(tmp_path):
    with chat_server() as chat:
        first = grounder(chat, tmp_path, price=(0.5, 2.0), run="one")
        first.prepare(tasks(3), nothing)
        second = grounder(chat, tmp_path, price=(0.5, 2.0), run="two")
        second.prepare(tasks(5), nothing)
        for task in tasks(5):  # judging asks again, and gets what is kept
            second.propose(task)
    told = usage(second.endpoint, "plan")
    assert (told["requests"], told["new"], told["kept"]) == (5, 2, 3)
    assert (told["prompt_tokens"], told["completion_tokens"]) == (5000, 100)
    assert told["dollars"] == pytest.approx(5 * (1000 * 0.5 + 20 * 2.0) / 1e6)
    assert told["new_dollars"] == pytest.approx(2 * (1000 * 0.5 + 20 * 2.0) / 1e6)
    assert told["models"] == ["test-model-2026"]
    assert 0 < told["latency_s"]["median"] <= told["latency_s"]["p95"]
    assert usage(first.endpoint, "plan")["requests"] == 3


def test_damaged_replies_are_asked_for_again(tmp_path, caplog):
    with chat_server() as chat:
        own = grounder(chat, tmp_path)
        own.propose(tasks(1)[0])
        (path,) = tmp_path.rglob("*/*.json")
        path.write_text(path.read_text()[:50])
        assert own.propose(tasks(1)[0]).actions
        assert list(chat.seen.values()) == [2]
    assert "the reply is damaged" in caplog.text


def run(chat, folder, count):
    return forked(ask, chat.url, folder, count)


@pytest.mark.slow
def test_who_is_killed_goes_on_and_pays_for_nothing_twice(tmp_path):
    """What was under way is in doubt: it is asked again, and counted. Nothing else is."""
    with chat_server(delay_s=0.15) as chat:
        killed = run(chat, tmp_path, 60)
        while sum(chat.answered.values()) < 20:
            assert killed.is_alive()
            time.sleep(0.01)
        killed.kill()
        killed.join()
        time.sleep(0.4)  # until the server is done with what was under way
        kept = {
            json.loads(p.read_text())["request"]["messages"][1]["content"]
            for p in tmp_path.rglob("*.json")
        }
        doubtful = len(list(tmp_path.rglob("*.asked")))
        before = dict(chat.seen)
        assert 12 <= len(kept) < 60
        assert 0 < doubtful <= 8

        again = run(chat, tmp_path, 60)
        again.join(120)
        assert again.exitcode == 0
    twice = [body for body, count in chat.seen.items() if count > 1]
    assert len(chat.seen) == 60
    assert max(chat.seen.values()) <= 2
    assert len(twice) <= doubtful
    assert not any(json.loads(body)["messages"][1]["content"] in kept for body in twice)
    assert all(before.get(body) == 1 for body in twice)
    own = grounder(chat, tmp_path)
    replies = [own.endpoint.replies.reply(p.stem) for p in tmp_path.rglob("*.json")]
    assert len(replies) == 60
    assert len(twice) <= sum(reply.in_doubt for reply in replies) <= doubtful
    unanswered = [p for p in tmp_path.rglob("*.asked") if not p.with_suffix(".json").exists()]
    assert unanswered == []


@pytest.mark.slow
def test_two_programs_at_once_share_what_they_pay(tmp_path):
    with chat_server(delay_s=0.1) as chat:
        both = [run(chat, tmp_path, 20) for _ in range(2)]
        for program in both:
            program.join(120)
    assert [program.exitcode for program in both] == [0, 0]
    assert set(chat.seen.values()) == {1}


def test_verdicts(tmp_path):
    (task,) = tasks(1)
    with chat_server() as chat:
        own = grounder(chat, tmp_path)
        judge = LanguageModelJudge(own.endpoint)
        actions = tuple(own.propose(task).actions)
        context = task.start.context
        picked = JudgedPlan(task.text, planned(context, actions), actions, context)
        idle = JudgedPlan(task.text, planned(context, ()), (), context)
        assert judge.verdict(picked).correct
        said = judge.verdict(idle)
        assert (said.correct, said.reason) == (False, "nothing was moved")
        asked = chat.bodies[1]["messages"][1]["content"]
    assert "p1 was picked up and is on the forks at the end" in asked
    assert "the robot drove by [0.0, 0.0]" in asked


def test_json_in_what_models_put_around_it():
    assert json_in('```json\n{"a": {"b": 1}}\n```') == '{"a": {"b": 1}}'
    assert json_in("no") == "no"
