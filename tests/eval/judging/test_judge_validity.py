"""The automatic judge against people, on judgments that are made up so that the answer is known."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from sklearn.metrics import cohen_kappa_score, roc_auc_score

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.importers.treebank import robot_alone
from eval.cli.eval_commands import evaluate
from eval.judging.execution import counterparts, logged, replayed
from eval.judging.judge import Verdict, judge
from eval.judging.judge_registry import JUDGES, judge_named, plan_judge
from eval.judging.judge_report import in_a_line, with_validity
from eval.judging.judge_validity import (
    CHOSEN_ON,
    ENDS,
    WORDS,
    agreement,
    cohens_kappa,
    contexts_of_videos,
    judge_validity,
    known_validity,
)
from g3.annotation import Annotation, Command, Judgment
from g3.errors import FormatError
from g3.sdc.sdc_notation import parse_brackets

TESTED_ON = {
    "go_to_receiving_loaded",
    "move_box_pallet_from_truck_to_truck",
    "move_tire_pallet",
    "pickup_box_pallet",
    "put_box_pallet_in_storage",
    "put_down_box_pallet",
    "put_tire_pallet_on_trailer",
}
"""The paper's scenarios on which no rule of the second verdict was chosen."""


@pytest.fixture(scope="module")
def whole():
    return open_corpus("warehouse")


@pytest.fixture(scope="module")
def of_layout(whole):
    """Three videos of a layout, by the names of their scenarios."""
    contexts = contexts_of_videos(whole)
    names = sorted(name for name in contexts if name.startswith("hall_"))[:3]
    return {name: contexts[name] for name in names}


def test_a_robot_alone_is_no_world_of_its_command_and_video():
    command = Command("c", "Land.", "fly", video="fly")
    sdcs = parse_brackets("EVENT(r = Land)", command=command.text)
    nothing = {"groundings": ((), ()), "correct": (None, None), "source": "positive"}
    trees = [Annotation("a", command, robot_alone("fly"), sdcs, **nothing)]
    corpus = Corpus.build(
        "drone", contexts=[robot_alone("fly")], commands=[command], annotations=trees
    )
    assert contexts_of_videos(corpus) == {}


def still_held(plan):
    """Right if something is on the forks at the end."""
    return Verdict(
        plan.execution.end.held is not None, "" if plan.execution.end.held else "they're empty"
    )


@pytest.fixture
def other_judge():
    plan_judge("still-held")(still_held)
    yield judge_named("still-held")
    JUDGES.remove("still-held")


def with_judgments(whole, videos, rating):
    """One command a video, rated by three people with every video."""
    commands = [next(c for c in whole.commands.values() if c.video == v) for v in videos]
    judgments = [
        Judgment(f"{c.id}-{shown}-{rater}", c.text, c.video, shown, given, f"r{rater}", "s")
        for c in commands
        for shown in videos
        for rater, given in enumerate(rating(c.video, shown))
    ]
    return Corpus.build(
        name="judged",
        contexts=list(videos.values()),
        commands=commands,
        annotations=[a for a in whole.annotations if a.command in commands],
        judgments=judgments,
        source="made up",
        licence="MIT",
    )


def plain(own, shown):
    return ("SA", "A", "N") if own == shown else ("SD", "D", "A")


def test_kappa_by_hand():
    # .70 of 50 alike, .50 by chance: (.7 - .5) / (1 - .5).
    assert cohens_kappa(np.array([[20.0, 5.0], [10.0, 15.0]])) == pytest.approx(0.4)
    assert np.isnan(cohens_kappa(np.array([[3.0, 0.0], [0.0, 0.0]])))


def test_precision_and_recall_by_hand():
    # Of three that the judge accepts people accept two, of the four that people accept it has two.
    people = [True] * 4 + [False] * 3
    said = [True, True, False, False, True, False, False]
    found = agreement(people, said, np.arange(7), lambda counts: counts[None].sum(axis=1))
    assert found.precision.value == pytest.approx(2 / 3)
    assert found.recall.value == pytest.approx(2 / 4)
    assert found.kappa.value == pytest.approx(cohen_kappa_score(people, said))
    assert found.n == 7
    assert found.counts["people_yes_judge_no"] == 2


def test_a_log_leads_in_its_own_world_to_what_the_judge_wants(whole):
    for context in whole.contexts.values():
        state = replayed(context, context)
        assert state is not None
        assert judge(context, state).correct, context.id


def test_things_of_two_maps_are_told_by_labels_and_places(of_layout):
    one = next(iter(of_layout.values()))
    renamed = replace(
        one,
        objects=tuple(
            o if o.id == one.agent_id else replace(o, id=f"new-{o.id}")
            for o in reversed(one.objects)
        ),
    )
    same = counterparts(one, renamed)
    assert same == {o.id: f"new-{o.id}" for o in one.objects if o.id != one.agent_id}


def test_a_log_that_moves_what_is_not_there_leads_nowhere(whole):
    world = whole.contexts["dock_pick_up_tires"]
    bare = replace(world, objects=tuple(o for o in world.objects if "tires" not in o.id))
    assert replayed(bare, world) is None


def test_figures_are_those_of_other_programs(whole, of_layout):
    def rating(own, shown):
        # Of one command's own video people think otherwise than the judge.
        return ("SD", "SD", "A") if own == shown == first else plain(own, shown)

    first = next(iter(of_layout))
    found = judge_validity(with_judgments(whole, of_layout, rating), seed=1, draws=200)
    people = [p.people for p in found.pairs]
    said = [p.verdicts[ENDS].correct for p in found.pairs]
    mean = [np.mean(p.ratings) for p in found.pairs]
    assert len(found.pairs) == 9
    assert found.together.kappa.value == pytest.approx(cohen_kappa_score(people, said))
    assert found.auc.value == pytest.approx(roc_auc_score(said, mean))
    assert found.together.accuracy.value == pytest.approx(8 / 9)
    assert np.isnan(found.together.accuracy.low)  # three videos tell too little
    (one,) = found.disagreements
    assert (one.command_video, one.shown_video, one.ratings) == (first, first, (1, 1, 4))
    again = judge_validity(with_judgments(whole, of_layout, rating), seed=1, draws=200)
    assert again.pairs == found.pairs
    assert (again.together.kappa, again.auc) == (found.together.kappa, found.auc)


def test_pairs_without_logs_are_counted_and_left_out(whole, of_layout):
    corpus = with_judgments(whole, of_layout, plain)
    other = replace(corpus.judgments[0], id="x", shown_video="elsewhere")
    corpus = replace(corpus, judgments=(*corpus.judgments, other))
    found = judge_validity(corpus, seed=0, draws=10)
    assert (len(found.pairs), found.left_out) == (9, 1)


def test_near_misses_are_apart_from_own_videos(whole, of_layout):
    found = judge_validity(with_judgments(whole, of_layout, plain), seed=0, draws=10)
    for verdict in (ENDS, WORDS):
        groups = found.near_misses[verdict]
        assert {name: group.n for name, group in groups.items()} == {
            "all": 6, "chosen_on": 0, "others": 6,
        }  # fmt: skip
        # People refuse all of these.
        assert groups["all"].counts["people_yes_judge_no"] == 0
        assert found.own_videos[verdict].counts["people_yes_judge_yes"] == 3


def test_a_command_that_nobody_annotated_has_no_verdict_by_words(whole, of_layout):
    corpus = with_judgments(whole, of_layout, plain)
    left = next(iter(corpus.commands.values()))
    corpus = replace(corpus, annotations=tuple(a for a in corpus.annotations if a.command != left))
    found = judge_validity(corpus, seed=0, draws=10)
    assert found.near_misses[ENDS]["all"].n == 6
    assert found.near_misses[WORDS]["all"].n == 4
    assert sum(WORDS not in p.verdicts for p in found.pairs) == 3


@pytest.fixture(scope="module")
def rated(published):
    """The paper's 15 scenarios, whatever else is there."""
    corpus, _ = published
    names = {a.command.scenario for a in corpus.annotations}
    assert names >= CHOSEN_ON | TESTED_ON
    videos = {c.video for c in corpus.commands.values() if c.scenario in CHOSEN_ON | TESTED_ON}
    judged = (j for j in corpus.judgments if {j.command_video, j.shown_video} <= videos)
    return replace(corpus, judgments=tuple(judged))


def test_on_near_misses_that_no_rule_was_chosen_on_it_agrees_with_people(rated):
    found = judge_validity(rated, seed=0, draws=100).near_misses
    assert found[WORDS]["others"].n >= 50
    assert found[WORDS]["others"].kappa.value >= 0.4 > found[ENDS]["others"].kappa.value


def test_without_judgments_it_is_not_known(whole):
    with pytest.raises(FormatError, match="no judgments"):
        judge_validity(whole, seed=0, draws=10)
    assert known_validity([whole], seed=0, draws=10) is None
    assert "isn't known" in in_a_line(None)


def test_table_3_has_it_beside_its_figures(whole, of_layout):
    corpus = with_judgments(whole, of_layout, plain)
    found = known_validity([whole, corpus], seed=0, draws=10)
    assert "does what the words say: kappa" in in_a_line(found)
    made = json.loads(with_validity('{"table": 3, "rows": []}', found))
    assert made["judge_validity"]["all_pairs"][ENDS]["kappa"]["value"] == 1.0
    assert json.loads(with_validity('{"table": 3}', None))["judge_validity"] is None


def test_the_command_tells_figures_and_disagreements(whole, of_layout, tmp_path):
    path = tmp_path / "judged"
    with_judgments(whole, of_layout, plain).save(path)
    arguments = ["--judge-validity", "--corpus", str(path), "--draws", "50"]
    done = CliRunner().invoke(evaluate, [*arguments, "--format", "json"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["judge"] == "automatic"
    assert found["compared_with"] == "people"
    assert found["all_pairs"][ENDS]["kappa"]["value"] == 1.0
    assert found["own_videos"][WORDS]["counts"]["people_yes_judge_yes"] == 3
    assert found["disagreements"] == []
    shown = CliRunner().invoke(evaluate, arguments).stdout
    assert shown.startswith("Near misses")
    assert shown.index("Near misses") < shown.index("their own video")
    assert "by construction" in shown
    assert CliRunner().invoke(evaluate, [*arguments, "--jobs", "2"]).stdout == shown


@pytest.mark.parametrize("wrong", [["--format", "csv"], ["--test", "warehouse"], ["--top", "3"]])
def test_what_does_not_go_with_it_is_refused(wrong):
    done = CliRunner().invoke(evaluate, ["--judge-validity", "--corpus", "warehouse", *wrong])
    assert done.exit_code == 2
    assert CliRunner().invoke(evaluate, ["--judge-validity"]).exit_code == 2


def test_another_judge_is_compared_with_people_on_the_same_pairs(
    whole, of_layout, other_judge, tmp_path
):
    corpus = with_judgments(whole, of_layout, plain)
    found = judge_validity(corpus, seed=0, draws=20, other=other_judge)
    said = {(p.command_video, p.shown_video): p.verdicts for p in found.pairs}
    held = {v: logged(context).end.held is not None for v, context in of_layout.items()}
    assert set(held.values()) == {True, False}
    for (_, shown), verdicts in said.items():
        assert verdicts["still-held"].correct == held[shown]
    counts = found.near_misses["still-held"]["all"].counts
    assert sum(counts.values()) == found.near_misses[ENDS]["all"].n
    corpus.save(tmp_path / "rated")
    asked = ["--judge-validity", "--corpus", str(tmp_path / "rated"), "--judge", "still-held"]
    done = CliRunner().invoke(evaluate, [*asked, "--json"])
    assert done.exit_code == 0, done.output
    content = json.loads(done.stdout)
    assert content["near_misses"]["still-held"]["all"]["counts"] == counts
    assert content["other_judge"] == {"still-held": {"module": __name__}}
    assert "the judge still-held" in CliRunner().invoke(evaluate, asked).stdout
