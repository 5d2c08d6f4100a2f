"""``ct eval --on-trial``: potentials and feature sets switched off in turn."""

import json
import shutil

import pytest
from click.testing import CliRunner

from eval.cli.eval_commands import evaluate
from eval.on_trial import ablation_runs
from eval.on_trial.ablation_report import COLUMNS, render, rows, sign_test, verdict
from eval.on_trial.ablation_runs import NOTHING, Ablations, on_trial, run
from eval.table_3 import end_to_end
from eval.table_3.outcomes import Outcome
from g3.errors import CorpusError, ModelError
from g3.inference.potentials.potential_registry import potentials

COMMANDS = ("court_put_crate_on_trailer-01", "hall_pick_up_boxes-01")


# Counting


def told(*correct):
    return [Outcome(f"c{i}", "s", "Go.", 0.5, bool(c), "") for i, c in enumerate(correct)]


def test_counts_worked_by_hand():
    outcomes = {
        # Six commands: right, right, right, wrong, wrong, right.
        "a": {
            NOTHING: told(1, 1, 1, 0, 0, 1),
            "side": told(0, 0, 0, 1),  # won three, lost one
            "room": told(0, 0, 0, 0, 0, 0),  # won four
        },
        "b": {NOTHING: told(0, 1), "side": told(1, 1)},  # lost one
    }
    found = rows(
        outcomes, [("side", "potential"), ("room", "potential"), ("labels", "feature set")]
    )
    assert [(r["corpus"], r["name"], r["n"], r["spoke"], r["won"], r["lost"]) for r in found] == [
        ("a", "side", 6, 4, 3, 1),
        ("a", "room", 6, 6, 4, 0),
        ("a", "labels", 6, 0, 0, 0),
        ("b", "side", 2, 2, 0, 1),
        ("b", "room", 2, 0, 0, 0),
        ("b", "labels", 2, 0, 0, 0),
    ]
    # Two tails of four coins: three or more heads 5/16 each; four heads 1/16 each.
    assert [r["p"] for r in found[:3]] == pytest.approx([10 / 16, 2 / 16, 1])
    # Holm: the least times three, the next times two, never less than the one before.
    assert [r["p_holm"] for r in found[:3]] == pytest.approx([1, 6 / 16, 1])
    assert [r["kind"] for r in found[:3]] == ["potential", "potential", "feature set"]


def test_sign_test_is_two_sided_and_exact():
    assert sign_test(0, 0) == 1
    assert sign_test(7, 0) == pytest.approx(2 / 2**7)
    assert sign_test(2, 9) == sign_test(9, 2) == pytest.approx(2 * (1 + 11 + 55) / 2**11)


@pytest.mark.parametrize(
    ("counts", "said"),
    [
        ([(3, 1), (2, 0)], "wins in 2 corpora"),
        ([(3, 1), (0, 0)], "wins in one only"),
        ([(3, 1)], "wins"),
        ([(3, 1), (0, 2)], "wins in some and loses in others"),
        ([(0, 1), (0, 0)], "loses"),
        ([(1, 1), (0, 0)], "wins as much as it loses"),
        ([(0, 0), (0, 0)], "changes nothing"),
    ],
)
def test_verdicts_in_plain_words(counts, said):
    own = []
    for number, (won, lost) in enumerate(counts):
        # Of that many commands as many are right without the potential as it loses.
        outcomes = {
            NOTHING: told(*[1] * won, *[0] * lost),
            "side": told(*[0] * won, *[1] * lost),
        }
        own += rows({f"corpus {number}": outcomes}, [("side", "potential")])
    assert verdict(own) == said
    text = render(own, "text", {})
    (line,) = [one for one in text.splitlines() if one.startswith("side")]
    assert line.endswith(said)
    assert json.loads(render(own, "json", {}))["verdicts"] == {"side": said}
    assert render(own, "csv", {}).splitlines()[1].endswith(said)


# What is tried


def test_all_potentials_are_tried_and_feature_sets_if_asked():
    everything = tuple(p.name for p in potentials())
    assert on_trial((), ()) == (everything, ())
    assert on_trial(("side", "room", "side"), ()) == (("side", "room"), ())
    assert on_trial((), ("labels",)) == ((), ("labels",))
    some, sets = on_trial((), (), all_sets=True)
    assert some == everything
    assert "labels" in sets
    with pytest.raises(ModelError, match="no potential 'smell'"):
        on_trial(("smell",), ())
    with pytest.raises(ModelError, match="no feature set 'smell'"):
        on_trial((), ("smell",))


def ran(*arguments):
    return CliRunner().invoke(evaluate, ["--on-trial", *arguments])


def test_a_potential_that_says_nothing_changes_nothing(few):
    """Commands are not followed again without it, and Table 3 shows that they needn't be."""
    found = run(Ablations((few,), (few,), ("verb-take", "side", "alone", "ordinal")))[few]
    assert set(found) == {NOTHING, "verb-take", "side"}
    for name in ("alone", "ordinal", "verb-take"):
        followed = end_to_end.run(few, few, configurations=("gold",), ablate=(name,))
        without = {o.command: o.evidence for o in followed.outcomes["gold"]}
        sparse = {o.command: o.evidence for o in (*found[NOTHING], *found.get(name, ()))}
        assert sparse == without


def test_what_two_potentials_and_a_feature_set_win_in_two_corpora(few, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(few, other)
    asked = ["--train", few, "--test", f"{few},{other}", "--json", "--most", "1"]
    names = ["--potential", "verb-put", "--potential", "ordinal", "--feature-set", "labels"]
    done = ran(*asked, *names)
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["judge"] == "automatic"
    assert [(r["name"], r["kind"]) for r in found["rows"]] == 2 * [
        ("verb-put", "potential"),
        ("ordinal", "potential"),
        ("labels", "feature set"),
    ]
    for row in found["rows"]:
        assert list(row) == list(COLUMNS)
        assert row["corpus"] in {few, str(other)}
        assert row["n"] == 2
    # One of the two commands puts a load down; neither command has an ordinal.
    by_name = {r["name"]: (r["spoke"], r["won"], r["lost"], r["p"]) for r in found["rows"][:3]}
    assert by_name["verb-put"] == (1, 1, 0, 1.0)
    assert by_name["ordinal"] == (0, 0, 0, 1.0)
    assert by_name["labels"][0] == 2
    assert found["verdicts"]["verb-put"] == "wins in 2 corpora"
    assert found["verdicts"]["ordinal"] == "changes nothing"


@pytest.mark.slow
def test_it_is_the_same_in_several_processes(few):
    asked = ["--train", few, "--test", few, "--potential", "verb-take", "--json"]
    alone, together = ran(*asked), ran(*asked, "--jobs", "2")
    assert together.exit_code == 0, together.output
    assert together.stdout == alone.stdout


def test_a_run_that_was_stopped_goes_on(few, tmp_path, monkeypatch):
    out = tmp_path / "trial.json"
    asked = ["--train", few, "--test", few, "--potential", "verb-take", "--json"]
    whole = ran(*asked).stdout
    asked += ["--out", str(out)]
    follow, begun = ablation_runs.follow_command, []

    def stopping(which, tested, *others):
        begun.append(tested.command.scenario)
        if len(set(begun)) == 2:
            raise KeyboardInterrupt
        return follow(which, tested, *others)

    monkeypatch.setattr(ablation_runs, "follow_command", stopping)
    assert ran(*asked).exit_code
    (part,) = tmp_path.iterdir()
    assert part.name == "trial.json.part"
    first = begun[0]
    begun.clear()

    def noting(which, tested, *others):
        begun.append(tested.command.scenario)
        return follow(which, tested, *others)

    monkeypatch.setattr(ablation_runs, "follow_command", noting)
    again = ran(*asked)
    assert again.exit_code == 0, again.output
    assert "1 scenarios are done already" in again.stderr
    assert begun
    assert first not in begun
    assert out.read_text() == whole
    assert list(tmp_path.iterdir()) == [out]


def test_a_scenario_that_fails_is_told_after_the_others(few, monkeypatch):
    follow = ablation_runs.follow_command

    def failing(which, tested, *others):
        if tested.command.id == COMMANDS[0]:
            raise ValueError("it broke")
        return follow(which, tested, *others)

    monkeypatch.setattr(ablation_runs, "follow_command", failing)
    done = []
    with pytest.raises(CorpusError, match="commands of 1 scenarios can't be followed: court"):
        run(Ablations((few,), (few,)), on_part=lambda key, _: done.append(key))
    assert [key.split(" | ")[-1] for key in done] == ["hall_pick_up_boxes"]


def test_extracted_clauses_can_be_taken_throughout(few):
    gold, auto = (
        run(Ablations((few,), (few,), clauses=clauses))[few][NOTHING]
        for clauses in ("gold", "auto")
    )
    assert [o.command for o in gold] == [o.command for o in auto]
    # Words of clauses are judged only where people have annotated them.
    assert all(o.by_words is not None for o in gold)
    assert all(o.by_words is None for o in auto)


def test_corpora_to_test_on_must_be_named():
    done = ran("--train", "warehouse", "--test", ",")
    assert done.exit_code == 2
    assert "name a corpus" in done.stderr
