"""Rating sets: which plans are drawn, what is expected, and what ratings say of the judge."""

from __future__ import annotations

import json
from collections import Counter

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from corpus_tools.cli.console import run
from corpus_tools.following.plan_execution import KeptPlace, PlanScript
from corpus_tools.world.state.robot_script import TURN, WAIT, ScriptStep
from eval.cli.eval_commands import evaluate
from eval.plan_study.rating_sample import (
    Sample,
    distinct_plans,
    draw,
    half_widths,
    planned,
    quotas,
    sampled,
)
from eval.plan_study.rating_set import RunOutcome, lines_planned, most_people, prepare
from eval.plan_study.study_plans import (
    CONFIGURATIONS,
    INSTANCE,
    PLANS,
    RUNS,
    Pair,
    PlanRecord,
    Settings,
    Unit,
    check_settings,
    chosen_commands,
    plan_all,
    script_digest,
    settings_for,
)
from eval.statistics.power import design_effect, plan_interval
from g3.annotation import Judgment
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, engine_of
from tests.eval.plan_study.made_plans import plans_of, record, waiting
from tests.tiny_corpus import tiny_corpus

LAB = "https://lab.example.org"


# What is drawn


def test_a_plan_of_two_configurations_is_one():
    same = [
        record("gold", "a/1", "s", waiting(1.0), right=True),
        record("auto", "a/1", "s", waiting(1.00001), right=True),
        record("random", "a/1", "s", waiting(2.0), right=False),
        record("gold", "a/2", "s", waiting(1.0), right=True),
        record("auto", "a/2", "s", None, right=False),
    ]
    found = distinct_plans(same)
    assert sorted((p.record.command, p.configurations) for p in found) == [
        ("a/1", ("auto", "gold")), ("a/1", ("random",)), ("a/2", ("gold",)),
    ]  # fmt: skip
    assert not any(name in p.run for p in found for name in (*CONFIGURATIONS, "/"))


def test_scripts_with_other_places_are_other_plans():
    def put(x):
        corners = ((x, 0.0), (x + 1, 0.0), (x, 1.0))
        return PlanScript(
            (ScriptStep("put_down", "place-1"),), {"place-1": KeptPlace(corners, 0.0, 1.0)}
        )

    assert script_digest(put(1.0)) == script_digest(put(1.0 + 1e-9)) != script_digest(put(2.0))
    kept = msgspec.json.decode(msgspec.json.encode(put(1.0)), type=PlanScript)
    assert kept == put(1.0)
    assert kept.places["place-1"].prism.xy.tolist() == [[1, 0], [2, 0], [1, 1]]


@pytest.mark.parametrize(
    ("sizes", "most", "wanted"),
    [
        ({"wrong": 300, "right": 100}, 200, {"wrong": 150, "right": 50}),
        ({"wrong": 100, "right": 300}, 200, {"wrong": 100, "right": 100}),
        ({"wrong": 300, "right": 20}, 200, {"wrong": 180, "right": 20}),
        ({"right": 300, "wrong": 100}, 200, {"right": 150, "wrong": 50}),
        ({"wrong": 30, "right": 10}, 200, {"wrong": 30, "right": 10}),
        ({"wrong": 30, "right": 10}, 0, {"wrong": 30, "right": 10}),
        ({"wrong": 30, "right": 10}, 3, {"wrong": 2, "right": 1}),
        ({"wrong": 30, "right": 10}, 1, {"wrong": 1, "right": 0}),
        ({"wrong": 300}, 200, {"wrong": 200}),
        ({"wrong": 0, "right": 10}, 8, {"wrong": 0, "right": 8}),
    ],
)
def test_the_first_kind_counts_most(sizes, most, wanted):
    assert quotas(sizes, most) == wanted
    assert list(quotas(sizes, most)) == list(sizes)


def test_scenarios_and_configurations_are_balanced():
    # Scenario 0 has three times as many wrong plans as each other, gold twice as many as auto.
    kinds = [
        record(which, f"{scenario}-{i}", scenario, waiting(1.0 + (which == "auto")), right=False)
        for scenario, count in (("s0", 12), ("s1", 4), ("s2", 4))
        for which, part in (("gold", 1), ("auto", 2))
        for i in range(count // part)
    ]
    plans = distinct_plans(kinds)
    sample = draw(plans, ["wrong"], 12, seed=5)
    drawn = [p for p in plans if p.run in sample.chance]
    cells = Counter((p.record.scenario, p.configurations) for p in drawn)
    assert set(cells.values()) == {2}
    assert len(cells) == 6
    # Two of twelve, of six, of four and of two.
    assert {sample.chance[p.run] for p in drawn if p.record.scenario == "s0"} == {1 / 6, 1 / 3}
    assert {sample.chance[p.run] for p in drawn if p.record.scenario == "s1"} == {1 / 2, 1}
    assert draw(plans, ["wrong"], 12, seed=5) == sample != draw(plans, ["wrong"], 12, seed=6)


def test_a_sample_is_drawn_once(tmp_path):
    plans = plans_of(["wrong"] * 20)
    settings = Settings("a", "b", 0, 1.0, 3, (), ("wrong",), 4)
    sample = sampled(tmp_path, plans, settings)
    assert (sample.seed, sample.judge, len(sample.chance)) == (3, "log", 4)
    assert sampled(tmp_path, plans_of(["wrong"] * 30), settings) == sample


def test_most_people_decide():
    pairs = [Pair("Go.", f"r{i}", "own", "gold", f"c{i}") for i in range(3)]
    told = [("r1", "A"), ("r1", "D"), ("r0", "SA"), ("r0", "A"), ("r0", "SD")]
    judgments = [
        Judgment(str(i), "Go.", "own", run, rating, f"p{i}", "plans")
        for i, (run, rating) in enumerate(told)
    ]
    assert most_people(pairs, judgments) == {"r1": False, "r0": True}
    assert most_people(pairs, []) == {}
    with pytest.raises(FormatError, match="no pair"):
        most_people(pairs[:1], judgments)


# What is expected


def test_expected_widths_are_those_of_the_formula():
    plans = plans_of(["wrong"] * 300 + ["right"] * 100, scenarios=20)
    sample = draw(plans, ["wrong", "right"], 200, seed=0)
    shares = {"wrong": 0.2, "right": 0.8}

    def widths(correlation):
        rng = np.random.default_rng(0)
        options = {"shares": shares, "correlation": correlation, "studies": 4000}
        return {n: w.value for n, w in half_widths(plans, sample, rng, **options).items()}

    alone = plan_interval(0.111, share=0.8, judges=1, correlation=0.0)
    assert alone.pairs == 50
    assert widths(0.0)["precision"] == pytest.approx(alone.half_width, rel=0.08)
    # Of fifty right plans, a fortieth part is of each of twenty scenarios: 2.5 on average.
    wider = np.sqrt(design_effect(2, 0.3) / 2 + design_effect(3, 0.3) / 2)
    assert widths(0.3)["precision"] == pytest.approx(alone.half_width * wider, rel=0.1)
    assert widths(0.0)["kappa"] < widths(0.3)["kappa"]


def test_what_is_planned_is_counted():
    plans = plans_of(["wrong"] * 30 + ["right"] * 10, configurations=("gold", "auto"))
    sample = draw(plans, ["wrong", "right"], 16, seed=0)
    found = planned(plans, sample, [20.0] * 16, without=3, stopped=2, seed=0)
    assert found.plans == {"wrong": 60, "right": 20}
    assert found.pairs == {"wrong": 12, "right": 4}
    assert found.configurations == {
        "random": {"wrong": 0, "right": 0},
        "gold": {"wrong": 6, "right": 2},
        "auto": {"wrong": 6, "right": 2},
    }
    assert (found.total, found.scenarios, found.raters, found.without, found.stopped) == (
        16,
        4,
        5,
        3,
        2,
    )
    # Twenty seconds to watch and ten to answer.
    assert (found.seconds_each, found.minutes) == (30.0, 8.0)
    assert 0 < found.half_widths["precision_of_wrong"] < found.half_widths["precision"] < 1
    nothing = planned(plans, Sample(0, "log", {}), [], without=0, stopped=0, seed=0)
    assert nothing.total == nothing.minutes == 0
    assert np.isnan(nothing.half_widths["kappa"])


# The command


@pytest.fixture
def study(tmp_path):
    """A folder whose plans are made already: short ones, of which two of three are shared."""
    corpus, folder = tmp_path / "tiny", tmp_path / "set"
    tiny_corpus().save(corpus)
    settings = settings_for(
        str(corpus), str(corpus), most=3, l2=1.0, seed=0, plans=("wrong", "right")
    )
    check_settings(folder, settings)
    (folder / PLANS).mkdir()
    for annotation in chosen_commands(settings):
        command = annotation.command
        for which in CONFIGURATIONS:
            right = which != "random" and command.scenario == "to_truck"
            step = ScriptStep(TURN.name, 20.0) if which == "random" else ScriptStep(WAIT.name, 0.5)
            kept = PlanRecord(
                which,
                command.id,
                command.scenario,
                command.text,
                0.5,
                right,
                "" if right else "it stands still",
                script=PlanScript((step,)),
                verdicts={"log": right},
            )
            name = Unit(which, annotation).name
            (folder / PLANS / f"{name}.json").write_bytes(msgspec.json.encode(kept))
    return folder


def test_nobody_rates_what_physics_stopped(study):
    corpus = str(study.parent / "tiny")
    settings = settings_for(corpus, corpus, most=3, l2=1.0, seed=0, plans=("wrong", "right"))
    plans = distinct_plans(plan_all(study, settings))
    stopped, *_ = [*draw(plans, settings.plans, 3, 0).chance]
    for plan in plans:
        outcome = RunOutcome(4.0, "it tips over" if plan.run == stopped else "")
        (study / RUNS / f"{plan.run}.json").write_bytes(msgspec.json.encode(outcome))
    found = prepare(study, settings)
    assert len(found.pairs) == found.planned.total == 2
    assert stopped not in {pair.video for pair in found.pairs}
    assert found.planned.stopped == 1
    assert found.planned.seconds_each == 14.0
    assert any("not rated: 1 plans" in line for line in lines_planned(found.planned))


@pytest.mark.slow
def test_a_rating_set_from_plans_to_ratings(study, capsys):
    corpus = str(study.parent / "tiny")
    arguments = ["eval", "--end-to-end", str(study), "--train", corpus, "--test", corpus]
    arguments += ["--plans", "wrong,right", "--most", "3", "--draws", "50"]

    def ct(*more):
        assert run([*arguments, *more]) == 0
        return capsys.readouterr()

    printed = ct("--format", "json", "--crowd", "links", "--url", LAB)
    # What is planned is said before; the link of --crowd comes after the videos.
    assert printed.err.index("expected half widths") < printed.err.index(f"{LAB}/crowd/links/")
    assert "plans by the automatic judge: 13 wrong, 3 right" in printed.err
    found = json.loads(printed.out)
    assert found["validity"] is None
    assert found["judgments"] == 0
    assert found["planned"]["pairs"] == {"wrong": 2, "right": 1}
    assert [one["people"] for one in found["rated"]] == [None] * 3
    assert ["auto", "gold"] in [one["configurations"] for one in found["rated"]]
    assert json.loads((study / "planned.json").read_text())["pairs"] == {"wrong": 2, "right": 1}
    videos = sorted((study / "videos").glob("*/video.mp4"))
    assert [video.parent.name for video in videos] == [one["run"] for one in found["rated"]]
    made = {path: path.stat().st_mtime_ns for path in (*videos, *(study / "runs").glob("*.json"))}
    assert "no ratings yet" in ct().out

    file = study / "study.yaml"
    assert not any(name in file.read_text() for name in (*CONFIGURATIONS, "wrong"))
    file.write_text(file.read_text().replace("practice: true", "practice: false"))
    ct("--crowd", "links", "--url", LAB)
    app = create_app(open_instance(study / INSTANCE))
    rater = Browser(app, study="plans")
    for _ in range(3):
        page = rater.lease("rate", "plans").json
        body = {"rating": 5, **rater.watched(page)}
        assert rater.answer(page["item"], body).status_code == 200
    engine_of(app).dispose()

    found = json.loads(ct("--format", "json").out)
    assert found["judgments"] == 3
    assert [one["people"] for one in found["rated"]] == [True] * 3
    every = found["validity"]["log"][0]
    assert every["counts"]["people_yes_judge_no"] == 2
    assert (every["plans"], every["rated"]) == (16, 3)
    assert every["precision"]["value"] == every["people_right"]["value"] == 1
    assert every["recall"]["value"] == pytest.approx(3 / 16)
    shown = ct().out
    assert "The automatic judge (log) against most people" in shown
    assert "3 of 3 pairs have ratings, 3 of 15 in all" in shown
    assert {path: path.stat().st_mtime_ns for path in made} == made

    (study.parent / "rated.json").write_text(json.dumps(found))
    report = ["eval", "--report", str(study.parent / "report"), "--corpus", corpus]
    assert run([*report, "--plans", str(study.parent / "rated.json")]) == 2
    refused = capsys.readouterr().err
    assert "rated.json" in refused
    assert "it is the result of a rating set" in refused
    assert "without --plans" in refused

    assert run([*arguments, "--seed", "1"]) == 2
    assert "another study" in capsys.readouterr().err


@pytest.mark.parametrize("kinds", ["good", "wrong,maybe", ","])
def test_only_wrong_and_right_plans_can_be_asked_for(kinds, tmp_path):
    arguments = ["--end-to-end", str(tmp_path / "x"), "--train", "a", "--test", "a"]
    done = CliRunner().invoke(evaluate, [*arguments, "--plans", kinds])
    assert done.exit_code == 2
    assert "give wrong, right or both" in done.stderr
