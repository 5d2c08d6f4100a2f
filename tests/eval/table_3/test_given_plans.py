"""``ct eval --table 3 --plans``: plans that another program has made, from a file."""

import json

import pytest
from click.testing import CliRunner

from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.eval_commands import evaluate
from eval.table_3.end_to_end import run, tasks_of
from eval.table_3.given_plans import read_plans, write_tasks
from eval.table_3.plan_rows import comparisons
from g3.errors import CorpusError, FormatError

FRIDGE, WASHER, TRAILER = "11", "12", "13"
PLANS = {
    "Pick up the refrigerator.": [{"action": "pick up", "object": FRIDGE}],
    "Lift the thing on the left.": [{"action": "pick up", "object": WASHER}],
    "Put the washing machine on the trailer.": [
        {"action": "carry", "object": WASHER, "on": TRAILER}
    ],
    "Pick up the washer and put it down.": [
        {"action": "pick up", "object": WASHER},
        {"action": "put down", "at": [3.0, 3.0]},
    ],
    "Turn around and go.": [],
    "Pick up the pallet.": [
        {"action": "pick up", "object": FRIDGE},
        {"action": "pick up", "object": FRIDGE},
    ],
}


@pytest.fixture
def form(folders, tmp_path):
    """The form as it is written, line by line."""
    file = tmp_path / "form.jsonl"
    assert write_tasks(file, tasks_of(open_corpus(folders[1]))) == len(PLANS)
    return [json.loads(line) for line in file.read_text().splitlines()]


def filled(form, plans=None):
    return [{**line, "actions": (plans or PLANS)[line["text"]]} for line in form]


def put(lines, path):
    path.write_text("\n".join(json.dumps(line) for line in lines) + "\n\n")
    return path


def test_the_form_shows_the_world_and_not_what_was_done(form):
    assert {line["text"] for line in form} == set(PLANS)
    for line in form:
        assert line["actions"] is None
        assert set(line) == {
            *("command", "heading", "actions", "probability", "note", "text", "scene"),
        }
        assert set(line["scene"]) <= {"robot", "position", "heading", "things", "places"}
    (one,) = (line for line in form if line["text"] == "Pick up the refrigerator.")
    things = {thing["id"]: thing for thing in one["scene"]["things"]}
    assert things[FRIDGE]["labels"] == ["refrigerator", "pallet"]
    assert things[FRIDGE]["liftable"]
    assert things[FRIDGE]["seen"][1] > 0 > things[WASHER]["seen"][1]


def test_plans_are_judged_as_worked_by_hand(form, folders, tmp_path):
    plans = read_plans(put(filled(form), tmp_path / "mine.jsonl"))
    result = run(*folders, configurations=("nearest", "keywords"), grounders=[plans])
    told = {o.text: (o.correct, o.theme, o.refused) for o in result.outcomes["mine"]}
    assert told == {
        "Pick up the refrigerator.": (True, True, False),
        "Lift the thing on the left.": (False, False, False),
        "Put the washing machine on the trailer.": (True, True, False),
        "Pick up the washer and put it down.": (True, True, False),
        "Turn around and go.": (False, False, True),
        "Pick up the pallet.": (False, False, True),  # it is on the forks already
    }
    reasons = {o.text: o.reason for o in result.outcomes["mine"]}
    assert reasons["Pick up the pallet."] == f"action 2: pick up: {FRIDGE} is on the forks"
    about = result.metadata["grounders"]["mine"]
    assert (about["file"], about["plans"]) == ("mine.jsonl", 6)
    compared = comparisons(result.outcomes, result.facts, draws=20, seed=0)
    (whole,) = (c for c in compared if (c.subset, c.verdict) == ("all", "precision"))
    both = {(c.one, c.other): c.difference.value for c in whole.comparisons}
    assert both == {
        ("nearest", "mine"): pytest.approx(1 / 6),
        ("keywords", "mine"): pytest.approx(2 / 6),
    }


def test_every_heading_wants_a_plan(folders, tmp_path):
    file = tmp_path / "form.jsonl"
    assert write_tasks(file, tasks_of(open_corpus(folders[1]), ["loads", "loads+180"], 1)) == 10
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    assert {line["heading"] for line in lines} == {"loads", "loads+180"}
    half = [line for line in filled(lines) if line["heading"] == "loads"]
    plans = read_plans(put(half, tmp_path / "half.jsonl"))
    with pytest.raises(FormatError, match=r"5 of 10 commands have no plan.*heading loads\+180"):
        run(*folders, headings=["loads", "loads+180"], most=1, grounders=[plans])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda lines: lines[1].pop("command"), r":2:1: .*missing required field `command`"),
        (lambda lines: lines[0].update(actions=None), ":1: the plan of command .* isn't filled in"),
        (lambda lines: lines.append(lines[2]), ":7: command .* has a plan in line 3 already"),
        (
            lambda lines: lines[3].update(probability=2),
            r":4:\d+: probability: expected",
        ),
        (lambda lines: lines[3].update(plan=[]), r":4:1: .*unknown field `plan`"),
        (lambda lines: lines[4].update(actions=[{"do": "it"}]), r":5:\d+: actions"),
        (
            lambda lines: lines[5].update(actions=[{"action": "pick up", "object": "moon"}]),
            r":6, command .*, action 1: there is no thing 'moon'",
        ),
        (lambda lines: lines.pop(), "1 of 6 commands have no plan, such as"),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_its_line(change, said, form, folders, tmp_path):
    lines = filled(form)
    change(lines)
    path = put(lines, tmp_path / "mine.jsonl")
    with pytest.raises(FormatError, match=said) as error:
        run(*folders, configurations=("nearest",), grounders=[read_plans(path)])
    assert str(path) in str(error.value)
    assert error.value.fix


def test_plans_that_are_not_asked_for_are_named(form, folders, tmp_path, capsys):
    lines = filled(form)
    path = put([{**lines[0], "command": "another"}, *lines], tmp_path / "mine.jsonl")
    run(*folders, configurations=("nearest",), grounders=[read_plans(path)])
    told = capsys.readouterr().err
    assert "mine.jsonl: 1 of 7 plans are of no command that is followed" in told
    assert "line 1" in told


def test_what_is_no_json_is_told_with_its_line(tmp_path):
    (tmp_path / "bad.jsonl").write_bytes(b'{"command": "a", "actions": []}\n{"comm\xff')
    with pytest.raises(FormatError, match=r"bad\.jsonl:2"):
        read_plans(tmp_path / "bad.jsonl")


def test_rows_have_different_names(form, folders, tmp_path):
    plans = read_plans(put(filled(form), tmp_path / "auto.jsonl"))
    with pytest.raises(CorpusError, match="two rows of Table 3 are called auto"):
        run(*folders, grounders=[plans])


@pytest.mark.slow
def test_the_command_writes_the_form_and_reads_it(folders, tmp_path):
    asked = ["--table", "3", "--judge", "automatic", "--train", folders[0], "--test", folders[1]]
    file = tmp_path / "mine.jsonl"
    done = CliRunner().invoke(evaluate, [*asked, "--write-tasks", str(file)])
    assert done.output == f"wrote {file}: 6 tasks\n"
    put(filled([json.loads(line) for line in file.read_text().splitlines()]), file)
    out = tmp_path / "table.json"
    asked += ["--draws", "20", "--plans", str(file), "--json", "--out", str(out)]
    done = CliRunner().invoke(evaluate, asked)
    assert done.exit_code == 0, done.output
    found = json.loads(out.read_text())
    (row,) = (r for r in found["rows"] if (r["configuration"], r["subset"]) == ("mine", "all"))
    assert (row["precision"], row["refusals"], row["n"]) == (0.5, 2, 6)
