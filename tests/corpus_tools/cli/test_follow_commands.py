"""``ct follow`` as people use it, with a small model."""

import json
import os
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.cli.follow_commands import follow
from corpus_tools.following.bundled_grounder import (
    kept_at,
    kept_model,
)
from corpus_tools.following.plan_execution import WAIT_S, run_plan, to_script
from corpus_tools.following.start_states import scenario_start
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.video import manifest
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import (
    BACK_UP,
    CARRY,
    DRIVE_TO,
    GO_STRAIGHT,
    LOWER_FORKS,
    PICK_UP,
    TURN,
    WAIT,
)
from g3.actions.grounding_candidates import are_free, spots_about, square
from g3.actions.robot_state import start_state
from g3.errors import CorpusError
from g3.geometry.footprints import centre, covers
from g3.inference.tree_choice import PARSES
from g3.learning.grounding_model import GroundingModel

SCENARIO = ["--scenario", "dock_pick_up_tires"]


@pytest.fixture(scope="module")
def model(trained):
    return ["--model", str(trained("one-scenario"))]


def run(*arguments, **options):
    return CliRunner().invoke(follow, list(arguments), **options)


def test_a_plan_is_shown_with_its_groundings(model):
    done = run("Pick up the boxes", *SCENARIO, *model, "--plan-only", "--format", "json")
    assert done.exit_code == 0, done.output
    (plan,) = json.loads(done.stdout)["plans"]
    assert plan["actions"][0].startswith("pick up boxes-")
    grounded = {g["text"]: g["objects"] for g in plan["groundings"]}
    assert grounded["the boxes"][0] in plan["actions"][0]


def test_the_same_command_gives_the_same_output(model):
    first, second = (
        run("Lift the boxes", *SCENARIO, *model, "--plan-only", "--explain") for _ in range(2)
    )
    assert first.exit_code == 0
    assert first.output == second.output


def test_reasons_are_told_in_plain_words(model):
    text = "Pick up the boxes and back up"
    done = run(text, *SCENARIO, *model, "--plan-only", "--explain")
    assert done.exit_code == 0, done.output
    lines = done.stdout.splitlines()
    assert any(
        line.startswith("  'the boxes': boxes-") and ", rather than " in line for line in lines
    )
    reasons = [line.strip() for line in lines if line.startswith("      ")]
    assert reasons
    told = (" likelier for ", " less likely for ", "nothing in these words")
    assert all(any(words in reason for words in told) for reason in reasons)
    assert not any("/" in line or "_" in line for line in reasons)


def test_a_rule_that_decides_is_named_and_can_be_switched_off(model):
    command = ("Pick up the boxes", *SCENARIO, *model, "--plan-only", "--explain")
    assert " for the rule verb-take: taking picks up" in run(*command).stdout
    assert "rule verb-take" not in run(*command, "--ablate", "verb-take").stdout
    done = run(*command, "--ablate", "verb-takes")
    assert isinstance(done.exception, CorpusError)
    assert "no potential 'verb-takes'" in str(done.exception)
    assert "did you mean 'verb-take'?" in done.exception.fix


def test_what_nobody_understands_is_refused_with_status_2(model):
    done = run("fly", *SCENARIO, *model, "--plan-only")
    assert done.exit_code == 2
    assert "'fly'" in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize("text", ["", "   "])
def test_an_empty_command_is_refused(text, model):
    done = run(text, *SCENARIO, *model, "--plan-only")
    assert isinstance(done.exception, CorpusError)
    assert "empty" in str(done.exception)


def test_an_unknown_scenario_is_refused(model):
    done = run("Pick up the boxes", "--scenario", "nowhere", *model, "--plan-only")
    assert isinstance(done.exception, CorpusError)
    assert "ct scenarios list" in str(done.exception)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["Lift it"], "Give either --scenario or --context."),
        ([*SCENARIO], "Give either TEXT or --interactive."),
        (["Lift it", *SCENARIO, "--video", "out.avi"], ".mp4"),
        (["Lift it", "--context", "warehouse"], "CORPUS:ID"),
    ],
)
def test_options_that_do_not_go_together_are_refused(arguments, message, model):
    done = run(*arguments, *model)
    assert done.exit_code == 2
    assert message in done.stderr


def test_the_interactive_loop_keeps_the_state_of_the_world(model):
    done = run(*SCENARIO, *model, "--interactive", "--plan-only", input="Lift the boxes\n1\n\n")
    assert done.exit_code == 0, done.output
    assert "pick up boxes-" in done.stdout


def test_an_unclear_answer_is_asked_again(model):
    said = "Lift the boxes\nthe blue sky\nnumber two\n\n"
    done = run(*SCENARIO, *model, "--interactive", "--plan-only", input=said)
    assert done.exit_code == 0, done.output
    assert "'the blue sky' doesn't pick out one" in done.stderr
    assert done.stderr.count("which:") == 2
    assert "pick up boxes-" in done.stdout


def test_plans_become_scripts(model):
    state = start_state(open_corpus("warehouse").contexts["dock_pick_up_tires"])
    place = square(np.array([10.0, 10.0]), 0.0, 0.0)
    actions = [
        Action(TURN, amount=np.pi / 2),
        Action(DRIVE_TO, target=(state.thing("trailer-1"),)),
        Action(CARRY, "tires-2", place=place),
    ]
    script = to_script(state, actions)
    steps = [(step.action, step.argument) for step in script.steps]
    assert steps == [
        ("turn_deg", pytest.approx(90.0)),
        ("approach", "trailer-1"),
        ("pick_up", "tires-2"),
        ("put_down", "place-1"),
    ]
    ((name, named),) = script.places.items()
    assert (name, named.prism.xy.tolist()) == ("place-1", place.prism.xy.tolist())
    # On a deck any spot will do: forks don't reach to its middle.
    on_deck = square(np.array([10.0, 10.0]), 0.0, 0.8)
    (wider,) = to_script(state, [Action(CARRY, "tires-2", place=on_deck)]).places.values()
    assert np.ptp(wider.prism.xy, axis=0) == pytest.approx(3 * np.ptp(on_deck.prism.xy, axis=0))
    assert (wider.prism.z_min, wider.prism.z_max) == (on_deck.prism.z_min, on_deck.prism.z_max)


@pytest.mark.parametrize(
    ("kind", "amount", "number"),
    [
        (GO_STRAIGHT, 2.5, 2.5),
        (BACK_UP, -1.5, 1.5),
        (TURN, -np.pi / 4, -45),
        (LOWER_FORKS, -0.3, 0.3),
        (LOWER_FORKS, 0.0, 0.0),
        (WAIT, 5.0, 5.0),
        (WAIT, 0.0, WAIT_S),
    ],
)
def test_scripts_have_the_amounts_that_were_said(kind, amount, number):
    context = open_corpus("warehouse").annotations[0].context
    (step,) = to_script(start_state(context), [Action(kind, amount=amount)]).steps
    assert step.argument == pytest.approx(number)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "load", "carrier"),
    [
        ("court_take_tires_to_issue", "tires-1", "truck-1"),
        ("yard_put_tires_on_truck", "tires-2", "truck-2"),
        ("dock_put_boxes_on_trailer", "boxes-1", "trailer-1"),
        # Its deck has a load already, and one end of it is a cab.
        ("depot_move_boxes_from_truck_to_trailer", "boxes-2", "truck-1"),
    ],
)
def test_plans_put_loads_on_decks(scenario, load, carrier):
    pytest.importorskip("mujoco")
    state = start_state(open_corpus("warehouse").contexts[scenario])
    deck = state.thing(carrier).prism
    place = next(
        spot
        for spot in spots_about((state.thing(carrier),), state)
        if spot.prism.z_min == deck.z_max and are_free([spot], state, load)[0]
    )
    done = run_plan(state, [Action(CARRY, load, place=place)], rate_hz=5.0)
    assert done.failure is None
    assert done.end.held is None
    end = done.end.thing(load).prism
    assert end.z_min == pytest.approx(deck.z_max, abs=0.02)
    assert covers(deck, centre(end))


def test_the_next_plan_begins_where_an_episode_has_ended():
    pytest.importorskip("mujoco")
    start = scenario_start("dock_pick_up_tires")
    (load,) = (o.id for o in start.context.objects if o.id == "tires-2")
    lifted = run_plan(start, [Action(PICK_UP, load)], rate_hz=5.0)
    assert (lifted.failure, lifted.end.held) == (None, load)
    after = run_plan(lifted.end, [Action(LOWER_FORKS, amount=0.0)], rate_hz=5.0)
    assert (after.failure, after.end.held, after.end.frame) == (None, load, start.frame)


YARD = ["--scenario", "yard_put_tires_on_truck"]


@pytest.mark.parametrize("how", [["--yes"], ["--plan-only"], []])
def test_what_the_forks_cannot_reach_is_said_before_anything_moves(model, how):
    done = run("Pick up the boxes", *YARD, *model, *how)
    assert done.exit_code == 2
    assert "pick up boxes-1" in done.stdout
    assert "it can't be carried out: " in done.stderr
    assert "over truck-1" in done.stderr
    assert "Do this?" not in done.stderr


def test_programs_are_told_what_the_forks_cannot_reach(model):
    done = run("Pick up the boxes", *YARD, *model, "--yes", "--json")
    told = json.loads(done.stdout)
    assert done.exit_code == 2
    assert (told["status"], told["execution"]) == ("impossible", None)
    assert "over truck-1" in told["plans"][0]["why_not"]
    other = json.loads(run("Pick up the boxes", *SCENARIO, *model, "--plan-only", "--json").stdout)
    assert (other["status"], other["plans"][0]["why_not"]) == ("found", "")


def test_the_loop_goes_on_after_a_plan_that_cannot_be_carried_out(model):
    said = "Pick up the boxes\nPick up the tires\n1\n\n"
    done = run(*YARD, *model, "--interactive", "--plan-only", input=said)
    assert done.exit_code == 0, done.output
    assert "over truck-1" in done.stderr
    assert "pick up tires-" in done.stdout


def test_plans_name_places_and_say_others_in_the_frame_of_the_scenario(model):
    named = run("Go to the wash bay", *YARD, *model, "--plan-only", "--explain")
    assert named.stdout.startswith("drive to wash bay  ")
    assert "wash bay (fits" in named.stdout
    assert "rather than drive to wash bay" not in named.stdout
    assert "rather than the place at wash bay" not in named.stdout
    beside = run("Put the left tires beside the barrel", *YARD, *model, "--plan-only").stdout
    x, y = map(float, beside.partition("at (")[2].partition(")")[0].split(", "))
    assert np.hypot(x - 8, y - 7) < 5, "the barrel is at 8, 7 in the scenario's file"


def test_a_plan_for_several_loads_is_explained(model):
    court = ("--scenario", "court_take_tires_to_issue")
    done = run("Put both tire pallets on the truck", *court, *model, "--plan-only", "--explain")
    assert done.exit_code == 0, done.output
    plan, _, explained = done.stdout.partition("\n")
    steps = plan.partition("  (")[0].split("; ")
    assert {step.partition(" onto ")[0] for step in steps} == {"carry tires-1", "carry tires-2"}
    assert all(" onto truck-1 at (" in step for step in steps)
    assert f"'Put both tire pallets on the truck': {'; '.join(steps)} (fits" in explained


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_no_training_is_announced_where_a_model_is_kept(trained, tmp_path, monkeypatch):
    corpus = open_corpus("warehouse")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert kept_model() is None
    path = kept_at(corpus.hash)
    path.parent.mkdir(parents=True, exist_ok=True)
    quick = GroundingModel.load(trained("one-scenario"))
    quick.card = {**quick.card, "corpus_hash": corpus.hash}
    quick.save(path)
    assert kept_model() is not None
    ours, theirs = os.openpty()
    command = ("follow", "Pick up the boxes", *SCENARIO, "--plan-only")
    done = subprocess.run(
        [sys.executable, "-m", "corpus_tools", *command],
        check=False,
        stdout=subprocess.PIPE,
        stderr=theirs,
    )
    os.write(theirs, b"end")
    shown = os.read(ours, 10_000).decode()
    assert done.returncode == 0
    assert b"pick up boxes-" in done.stdout
    assert shown == "end"


@pytest.mark.slow
def test_a_command_is_carried_out_and_filmed(model, tmp_path, monkeypatch):
    small = partial(manifest.Settings, size=(160, 120), quality="draft")
    monkeypatch.setattr(manifest, "Settings", small)
    video = tmp_path / "out.mp4"
    done = run("Pick up the boxes on the left", *SCENARIO, *model, "--video", str(video), "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["execution"]["failure"] is None
    assert told["execution"]["files"] == [str(video), str(video.with_suffix(".mcap"))]
    assert video.stat().st_size > 2_000
    assert video.with_suffix(".mcap").is_file()


def test_what_is_not_there_is_told_and_not_done(model):
    done = run("Lift the elephant", *SCENARIO, *model)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "I see no elephant here. There are: " in done.stderr
    assert "--yes" in done.stderr


def test_programs_are_told_what_is_not_there(model):
    done = run("Lift the elephant", *SCENARIO, *model, "--json")
    told = json.loads(done.stdout)
    assert done.exit_code == 2
    assert (told["status"], told["missing"], told["plans"]) == ("absent", ["elephant"], [])
    assert told["note"].startswith("I see no elephant here.")


def test_a_plan_can_be_had_all_the_same(model):
    done = run("Lift the elephant", *SCENARIO, *model, "--plan-only", "--yes", "--json")
    told = json.loads(done.stdout)
    # A plan that is hardly what was meant is still refused; but not for what is missing.
    assert told["missing"] == ["elephant"]
    assert told["status"] in ("found", "refused")
    assert "I see no" not in told["note"]


def test_without_a_terminal_nothing_unsure_is_done(model):
    command = ("Pick up the boxes on the left", *SCENARIO, *model, "--confirm-below", "1")
    done = run(*command)
    assert done.exit_code == 2
    assert "done in" not in done.stdout
    assert "do this? Its probability is " in done.stderr
    told = json.loads(run(*command, "--json").stdout)
    assert told["status"] == "unsure"
    assert told["question"].endswith("do this?")
    assert told["execution"] is None


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no terminals")
@pytest.mark.parametrize(("answer", "status"), [("y", 0), ("n", 2), ("", 2)])
def test_on_a_terminal_somebody_is_asked_first(model, answer, status):
    pytest.importorskip("mujoco")
    ours, theirs = os.openpty()
    command = [sys.executable, "-m", "corpus_tools", "follow", "Turn left", *SCENARIO, *model]
    process = subprocess.Popen(
        command, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    os.write(ours, f"{answer}\n".encode())
    out, err = process.communicate(timeout=300)
    os.close(ours)
    os.close(theirs)
    assert process.returncode == status, err
    assert "turn 90 degrees" in out
    assert "Do this? [y/N]" in err
    assert ("done in" in out) == (status == 0)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no terminals")
@pytest.mark.parametrize(
    ("more", "answers", "prompts"), [([], "the blue sky\n2\n", 2), (["--yes"], "", 0)]
)
def test_on_a_terminal_somebody_is_asked_which_one_is_meant(model, more, answers, prompts):
    ours, theirs = os.openpty()
    command = ("follow", "Lift the boxes", *SCENARIO, *model, "--plan-only", *more)
    process = subprocess.Popen(
        [sys.executable, "-m", "corpus_tools", *command],
        stdin=theirs,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.write(ours, answers.encode())
    out, err = process.communicate(timeout=300)
    os.close(ours)
    os.close(theirs)
    assert process.returncode == 0, err
    assert err.count("which:") == prompts
    assert "pick up boxes-" in out


def test_without_a_terminal_a_question_is_only_shown(model):
    done = run("Lift the boxes", *SCENARIO, *model, "--plan-only")
    assert done.exit_code == 0, done.output
    assert "? Which one is" in done.stdout
    assert "which:" not in done.stderr


def test_as_many_trees_are_summed_over_as_from_python():
    (option,) = (p for p in follow.params if p.name == "parses")
    assert option.default == PARSES
