"""``ct scenarios log``: scenarios executed in physics, and what the importer makes of them."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.cli.scenario_commands import scenarios
from corpus_tools.importers.authored.authored_corpus import import_authored

pytest.importorskip("mujoco")

DATASET = "name: tiny\nsource: A test.\nlicence: MIT\nseed: 1\nwords: {}\n"
LAYOUT = "title: A floor.\nat: [3, 4]\nyaw_deg: 30\nbounds: {x: [-9, 9], y: [-9, 9]}\n"
GO = """\
title: The forklift drives to the corner.
layout: floor
places:
  corner: {at: [6, 0], size: [3, 3]}
robot: {at: [0, 0]}
script:
  - drive_to: corner
commands:
  - {text: Go, sdcs: EVENT_1(r = Go), groundings: {}}
"""


WALLS = ((2.3, 0, 90), (-2.3, 0, 90), (0, 2.3, 0), (0, -2.3, 0))
"""Shelves all around the robot."""


def log(*arguments):
    return CliRunner().invoke(scenarios, ["log", *map(str, arguments)])


@pytest.fixture
def dataset(tmp_path):
    for name, text in (
        ("dataset.yaml", DATASET),
        ("layouts/floor.yaml", LAYOUT),
        ("scenarios/go.yaml", GO),
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_what_is_executed_is_imported(dataset):
    result = log("--dataset", dataset)
    assert result.output == f"1 log written to {dataset / 'logs'}\n"
    corpus, _ = import_authored(dataset)
    robot = corpus.contexts["go"].agent.trajectory
    turn = np.deg2rad(30)
    corner = [3 + 6 * np.cos(turn), 4 + 6 * np.sin(turn)]
    assert robot.xyz[-1, :2] == pytest.approx(corner, abs=0.5)
    assert np.allclose(np.diff(robot.t), 0.2)


def test_only_stale_logs_are_made_again(dataset):
    log("--dataset", dataset)
    file = dataset / "logs" / "go.mcap"
    before = file.read_bytes()
    assert "no logs written" in log("--dataset", dataset).output
    assert "1 log written" in log("go", "--dataset", dataset).output
    assert file.read_bytes() == before
    scenario = dataset / "scenarios" / "go.yaml"
    scenario.write_text(GO.replace("[0, 0]", "[-1, 0]"))
    told = json.loads(log("--dataset", dataset, "--json").output)
    assert told == {"folder": str(dataset / "logs"), "logged": ["go"], "failed": {}}
    assert file.read_bytes() != before
    import_authored(dataset)


def test_what_cannot_be_done_is_told_and_leaves_no_log(dataset):
    boxed_in = GO.replace(
        "places:",
        "objects:\n"
        + "".join(
            f"  shelf-{i}: {{kind: shelf, at: [{x}, {y}], yaw_deg: {yaw}}}\n"
            for i, (x, y, yaw) in enumerate(
                [(2.3, 0, 90), (-2.3, 0, 90), (0, 2.3, 0), (0, -2.3, 0)]
            )
        )
        + "places:",
    )
    (dataset / "scenarios" / "stuck.yaml").write_text(boxed_in)
    result = log("--dataset", dataset)
    assert result.exit_code == 2
    assert "1 log written" in result.output
    assert "stuck: drive_to corner" in result.output
    assert [file.name for file in (dataset / "logs").iterdir()] == ["go.mcap"]
    shutil.rmtree(dataset / "logs")


def test_unknown_names_are_told(dataset):
    assert log("nothing", "--dataset", dataset).exception is not None
