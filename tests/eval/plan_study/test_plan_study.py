"""Studies of plans: what is to rate, and what is made of ratings."""

import json
from collections import Counter
from dataclasses import replace

import msgspec
import pytest
from click.testing import CliRunner

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.eval_commands import evaluate
from eval.plan_study.study_plans import (
    Pair,
    PlanRecord,
    Settings,
    check_settings,
    film_all,
    pairs,
    plan_all,
    run_corpus,
    settings_for,
    write_study,
)
from eval.plan_study.whole_study import (
    Study,
    by_judge,
    by_people,
    check_ratings,
    compare_judge,
    compare_people,
    outcomes_of,
    render,
)
from g3.annotation import Judgment
from g3.errors import CorpusError, FormatError
from g3.groundings import Trajectory
from tests.eval.yard import few_annotated
from tests.tiny_corpus import tiny_corpus

COMMANDS = [a for a in open_corpus("warehouse").annotations if a.source == "positive"][:40]


def record(configuration, annotation, probability, *, correct=True):
    command = annotation.command
    return PlanRecord(
        configuration,
        command.id,
        command.scenario,
        command.text,
        probability,
        correct,
        "" if correct else "it stands still",
        f"{configuration}-{command.id}",
    )


@pytest.fixture(scope="module")
def records():
    return [
        record(which, a, 1 - i / 100, correct=which != "random" and i < 20)
        for i, a in enumerate(COMMANDS)
        for which in ("random", "gold", "auto")
    ]


@pytest.fixture(scope="module")
def found(records):
    return pairs(records, COMMANDS, seed=3)


def judgments_of(found, rating):
    return [
        Judgment(f"{i}-{rater}", p.text, p.own_video, p.video, rating(p), f"r{rater}", "plans")
        for i, p in enumerate(found)
        for rater in range(3)
    ]


def test_what_is_shown(found):
    scenarios = {a.command.scenario for a in COMMANDS}
    counts = Counter(p.configuration for p in found)
    assert counts == {
        "random": 40,
        "gold": 40,
        "auto": 30,
        "right": len(scenarios),
        "wrong": len(scenarios),
    }
    assert all((p.video == p.own_video) == (p.configuration == "right") for p in found)
    assert pairs([], COMMANDS, seed=3) == [p for p in found if not p.is_plan]


def test_a_command_without_a_plan_shows_nothing(records):
    without = [replace_run(r, "") if r.configuration == "gold" else r for r in records]
    assert Counter(p.configuration for p in pairs(without, COMMANDS, seed=0))["gold"] == 0


def replace_run(one, run):
    return msgspec.structs.replace(one, run=run)


def test_rows_by_people_and_by_the_judge_are_apart(found, records, tmp_path):
    def rating(pair):
        return "A" if pair.configuration in ("gold", "right") else "D"

    judgments = judgments_of(found, rating)
    people = by_people(found, records, judgments, seed=0, draws=50)
    automatic = by_judge(outcomes_of(records), seed=0, draws=50)
    study = Study(Settings("a", "b", 0, 1.0, 0), tmp_path, found, records, people, automatic, None)
    shown = json.loads(render(study, "json"))
    by_row = {row["configuration"]: row for row in shown["people"]}
    assert by_row["gold-all"]["precision"] == 1.0
    assert by_row["gold-all"]["n"] == 120
    assert by_row["gold-top30"]["n"] == 90
    assert by_row["random"]["precision"] == by_row["wrong"]["precision"] == 0.0
    assert {row["judge"] for row in shown["people"]} == {"people"}
    rows = {row["configuration"]: row for row in shown["automatic"]["rows"]}
    assert rows["gold-all"]["precision"] == 0.5
    assert rows["gold-top30"]["precision"] == pytest.approx(20 / 30)
    assert {row["judge"] for row in rows.values()} == {"automatic"}
    text = render(study, "text")
    assert text.index("People's judgments") < text.index("The automatic judge")
    again = by_people(found, records, judgments, seed=0, draws=50)
    assert repr(again) == repr(people)  # NaN, where there is no interval, is not equal to itself


def test_configurations_are_compared_on_the_commands_they_share(found, records, tmp_path):
    judgments = judgments_of(found, lambda p: "A" if p.configuration == "gold" else "D")
    people = compare_people(found, records, judgments, seed=0, draws=50)
    # Of extracted clauses only the most probable plans are rated.
    assert [(c.one, c.other, c.n) for c in people] == [
        ("random", "gold", 40), ("random", "auto", 30), ("gold", "auto", 30),
    ]  # fmt: skip
    assert [c.difference.value for c in people] == [-1.0, 0.0, 1.0]
    automatic = compare_judge(outcomes_of(records), seed=0, draws=50)
    assert {c.n for c in automatic} == {40}
    assert [c.difference.value for c in automatic] == [-0.5, -0.5, 0.0]
    study = Study(
        Settings("a", "b", 0, 1.0, 0), tmp_path, found, records, (), (), None, people, automatic
    )
    shown = json.loads(render(study, "json"))
    assert len(shown["people_compared"]) == len(shown["automatic"]["comparisons"]) == 3
    assert "People's judgments: configurations compared" in render(study, "text")


def test_without_ratings_only_the_judge_speaks(found, records, tmp_path):
    automatic = by_judge(outcomes_of(records), seed=0, draws=50)
    study = Study(Settings("a", "b", 0, 1.0, 0), tmp_path, found, records, (), automatic, None)
    assert json.loads(render(study, "json"))["people"] is None
    text = render(study, "text")
    assert "People's judgments" not in text
    assert "nobody has rated yet" in text


def test_ratings_of_unknown_pairs_and_second_ones_are_refused_with_their_row(found):
    judgments = judgments_of(found, lambda _: "A")
    check_ratings(found, judgments)
    strange = replace(judgments[4], shown_video="elsewhere")
    with pytest.raises(FormatError, match="no pair") as refused:
        check_ratings(found, [*judgments[:4], strange])
    assert refused.value.where == "judgments.jsonl: line 5"
    with pytest.raises(FormatError, match="rated this pair before") as refused:
        check_ratings(found, [*judgments[:2], judgments[0]])
    assert refused.value.where == "judgments.jsonl: line 3"


def test_each_video_is_made_once(tmp_path):
    (moving,) = tiny_corpus(("to_pallet",)).contexts.values()
    objects = tuple(
        replace(item, trajectory=Trajectory(way.t[:1], way.xyz[:1], way.yaw[:1]))
        for item in moving.objects
        for way in [item.trajectory]
    )
    still = replace(moving, id="still", objects=objects)
    corpus, folder = tmp_path / "corpus", tmp_path / "study"
    Corpus.build("c", contexts=[still], commands=[], annotations=[]).save(corpus)
    folder.mkdir()
    shown = [Pair(text, "still", "still", "right", text) for text in ("Stay.", "Wait.")]
    told = []
    for _ in range(2):
        film_all(folder, str(corpus), shown, lambda *args: told.append(args))
    assert told == [("videos: still", 1, 1)]
    assert (folder / "videos" / "still" / "video.mp4").stat().st_size > 1000
    with pytest.raises(CorpusError):
        film_all(folder, str(corpus), [Pair("Go.", "nowhere", "still", "wrong", "c")])


def test_a_folder_is_of_one_study(tmp_path):
    folder = tmp_path / "study"
    settings = Settings("a", "b", 2, 1.0, 0, ("x",))
    check_settings(folder, settings)
    check_settings(folder, settings)
    with pytest.raises(FormatError, match="another study"):
        check_settings(folder, Settings("a", "b", 3, 1.0, 0, ("x",)))
    (tmp_path / "mine.txt").touch()
    with pytest.raises(FormatError, match="other things"):
        check_settings(tmp_path, settings)


def test_the_study_does_not_tell_what_made_a_video(found, tmp_path):
    text = write_study(tmp_path, [Pair("Go.", "v", "w", "gold", "c")], seed=0).read_text()
    assert "gold" not in text.split("pairs:")[1]


@pytest.mark.parametrize(
    "wrong",
    [
        ["--format", "csv"],
        ["--corpus", "warehouse"],
        ["--top", "3"],
        ["--crowd", "links"],
        ["--pay", "0.05"],
    ],
)
def test_what_does_not_go_with_it_is_refused(wrong, tmp_path):
    arguments = ["--end-to-end", str(tmp_path / "x"), "--train", "warehouse", "--test", "warehouse"]
    assert CliRunner().invoke(evaluate, [*arguments, *wrong]).exit_code == 2
    assert CliRunner().invoke(evaluate, arguments[:2]).exit_code == 2
    assert not (tmp_path / "x").exists()


@pytest.mark.slow
def test_plans_are_kept_and_not_made_again(tmp_path):
    names = ("dock_pick_up_tires", "hall_pick_up_boxes")
    for folder, chosen in ((tmp_path / "two", names), (tmp_path / "one", names[1:])):
        few_annotated([f"{name}-01" for name in chosen], folder.name).save(folder)
    train, test = str(tmp_path / "two"), str(tmp_path / "one")
    settings = settings_for(train, test, most=1, l2=1.0, seed=0)
    folder = tmp_path / "study"
    check_settings(folder, settings)
    records = plan_all(folder, settings)
    assert [r.configuration for r in records] == ["random", "gold", "auto"]
    for r in records:
        if r.run:
            (run,) = Corpus.load(run_corpus(folder, r.run)).contexts.values()
            assert run.id == r.run
            assert len(run.agent.trajectory.t) > 1
    kept = {path: path.stat().st_mtime_ns for path in folder.rglob("*.json*")}
    assert plan_all(folder, settings) == records
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.json*")} == kept

    # A rating set makes the same plans and carries none out before it has drawn them.
    rating = settings_for(train, test, most=1, l2=1.0, seed=0, plans=("wrong",))
    assert (rating.most, rating.pairs) == (0, 1)
    later = tmp_path / "set"
    check_settings(later, rating)
    without_runs = [msgspec.structs.replace(r, run="", failure="") for r in records]
    assert plan_all(later, rating) == without_runs
    assert any(r.script and r.verdicts["log"] == r.correct for r in records)
    assert list((later / "runs").iterdir()) == []
