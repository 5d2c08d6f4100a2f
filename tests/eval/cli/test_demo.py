"""``ct demo``: its steps are commands that exist, and what is there isn't made again."""

import shlex

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.cli.console import run
from corpus_tools.cli.follow_commands import follow
from corpus_tools.cli.render_commands import render_videos
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.demo_commands import LEARNED_LAYOUTS, TESTED, demo, steps
from eval.cli.eval_commands import evaluate
from eval.cli.forklift_episodes import EPISODES

COMMANDS = {"eval": evaluate, "follow": follow, "render-videos": render_videos}


def test_each_step_is_a_command_with_options_that_it_has(tmp_path):
    plan = steps(tmp_path)
    for step in plan:  # options may want what earlier steps have made
        folder = not step.made.suffix
        step.made.mkdir() if folder else step.made.parent.mkdir(parents=True, exist_ok=True)
        if not folder:
            step.made.touch()
    lines = [shlex.split(step.line) for step in plan if step.line.startswith("ct ")]
    assert [line[1] for line in lines] == ["render-videos", "eval", "follow", "eval", "eval"]
    for line in lines:
        ctx = COMMANDS[line[1]].make_context("ct", line[2:])
        if line[1] == "eval":
            name, mode, rest = evaluate.resolve_command(ctx, [*ctx._protected_args, *ctx.args])
            mode.make_context(name, rest, parent=ctx)


def test_only_what_is_missing_is_made_of_scenarios_that_are_learned_from(tmp_path):
    missing = next(step.made for step in steps(tmp_path) if step.made.name == "few-tested")
    for step in steps(tmp_path):
        step.made.parent.mkdir(parents=True, exist_ok=True)
        if step.made != missing:
            step.made.touch()
    done = CliRunner().invoke(demo, ["--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert done.output.count("it is there") == len(steps(tmp_path)) - 1
    assert f"made {missing}" in done.output
    assert "report.html" in done.output
    tested = Corpus.load(missing)
    assert len(tested.commands) == sum(TESTED.values())
    assert {a.command.scenario for a in tested.annotations} == set(TESTED)
    assert all(name.startswith(LEARNED_LAYOUTS) for name in TESTED)


def test_it_needs_a_folder_to_be_in(tmp_path):
    done = CliRunner().invoke(demo, ["--out", str(tmp_path / "no" / "demo")])
    assert done.exit_code == 1
    assert "no such folder" in str(done.exception)


def moments(trajectory) -> np.ndarray:
    """The seconds at which the forklift stops, or starts forward or backward."""
    step = np.diff(trajectory.xyz[:, :2], axis=0)
    heading = np.column_stack([np.cos(trajectory.yaw[:-1]), np.sin(trajectory.yaw[:-1])])
    speed = (step * heading).sum(1) / np.diff(trajectory.t)
    way = np.where(np.abs(speed) < 0.05, 0, np.sign(speed))
    return trajectory.t[np.flatnonzero(np.diff(way)) + 1] - trajectory.t[0]


@pytest.mark.parametrize("scenario", EPISODES)
def test_true_subtasks_begin_where_the_forklift_changes_its_motion(scenario):
    context = open_corpus("warehouse").contexts[scenario]
    changes = np.append(moments(context.agent.trajectory), 0.0)
    starts = [start_s for start_s, _ in EPISODES[scenario].steps]
    assert starts == sorted(set(starts))
    assert all(np.abs(changes - start_s).min() < 0.05 for start_s in starts)


def test_one_subtask_is_wrong_in_each_episode():
    for episode in EPISODES.values():
        missing = set(episode.steps) - set(episode.written)
        added = set(episode.written) - set(episode.steps)
        assert (len(missing), len(added)) == (
            episode.right is not None,
            episode.wrong is not None,
        )


def test_an_option_of_the_group_is_not_lost(tmp_path, capsys):
    assert run(["demo", "--out", str(tmp_path), "episodes"]) == 2
    assert "after episodes" in capsys.readouterr().err
