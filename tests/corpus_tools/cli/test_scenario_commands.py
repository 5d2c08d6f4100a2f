"""``ct scenarios``."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from corpus_tools.cli.scenario_commands import scenarios
from corpus_tools.runtime.shipped import bundled
from tests.processes import ct

GOOD = """\
title: The forklift goes to receiving.
layout: dock
robot: {at: [0, 0]}
script:
  - drive_to: receiving
"""


def run(*arguments):
    return CliRunner().invoke(scenarios, [str(a) for a in arguments], catch_exceptions=False)


@pytest.fixture
def files(tmp_path):
    (tmp_path / "good.yaml").write_text(GOOD)
    (tmp_path / "bad.yaml").write_text(GOOD.replace("[0, 0]", "[0]").replace("title", "name"))
    return tmp_path


def test_check_lists_every_problem_with_its_line(files):
    result = run("check", files)
    assert result.exit_code == 2
    bad = files / "bad.yaml"
    assert [line.partition(" ")[0] for line in result.output.splitlines()] == [
        f"{bad}:1:1:",  # there is no title
        f"{bad}:1:7:",
        f"{bad}:3:13:",
        "2",
    ]
    assert result.output.endswith("2 scenarios: 3 problems\n")


def test_check_of_good_files(files):
    result = run("check", files / "good.yaml")
    assert result.exit_code == 0
    assert result.output == "1 scenario: no problems\n"


def test_check_for_programs(files):
    found = json.loads(run("check", files, "--format", "json").output)
    assert found["files"] == 2
    assert found["problems"][2] == {
        "where": f"{files / 'bad.yaml'}:3:13: robot.at",
        "what": "expected 2 numbers, got 1",
        "fix": "see docs/scenarios.md for the form",
    }


def test_list_names_layouts_and_titles(tmp_path):
    for name in ("scenarios", "layouts"):
        (tmp_path / name).mkdir()
    (tmp_path / "scenarios" / "go.yaml").write_text(GOOD)
    dock = bundled()["warehouse"] / "layouts" / "dock.yaml"
    (tmp_path / "layouts" / "dock.yaml").write_bytes(dock.read_bytes())
    assert run("list", "--dataset", tmp_path).output == (
        "go  dock  The forklift goes to receiving.\n"
    )
    rows = json.loads(run("list", "--dataset", tmp_path, "--format", "json").output)
    assert rows["scenarios"] == [
        {"id": "go", "layout": "dock", "title": "The forklift goes to receiving."}
    ]


def test_show_tells_what_is_there_and_draws_it(files):
    result = run("show", files / "good.yaml", "--out", files / "map.svg")
    assert result.exit_code == 0
    for words in ("Layout dock: A loading dock.", "receiving", "forklift", "1. drive_to receiving"):
        assert words in result.output
    assert "</svg>" in (files / "map.svg").read_text()
    shown = json.loads(run("show", files / "good.yaml", "--format", "json").output)
    assert shown["script"] == [{"action": "drive_to", "argument": "receiving"}]


def test_show_tells_where_the_robot_heads_in_the_frame_of_the_file():
    result = run("show", "yard_put_tires_on_truck")
    robot = next(line for line in result.output.splitlines() if "robot" in line)
    assert robot.split() == ["forklift", "robot", "12,", "0", "heading", "180"]
    turned = next(line for line in result.output.splitlines() if "boxes-1" in line)
    assert " ".join(turned.split()) == "boxes-1 box-pallet 0, 7.7 on truck-1 heading 90"


def test_kinds_lists_what_scenarios_can_name():
    assert "tire-pallet" in run("kinds").output
    found = json.loads(run("kinds", "--format", "json").output)
    assert {row["kind"] for row in found["kinds"]} >= {"truck", "trailer", "box-pallet"}
    assert {row["action"] for row in found["actions"]} >= {"pick_up", "put_down", "drive_to"}


def test_generate_gives_the_same_files_however_many(tmp_path):
    for count, folder in ((3, "few"), (6, "many")):
        result = run("generate", "--seed", 4, "--count", count, "--out", tmp_path / folder)
        assert result.exit_code == 0
    few = {file.name: file.read_bytes() for file in (tmp_path / "few").iterdir()}
    assert len(few) == 3
    for name, content in few.items():
        assert (tmp_path / "many" / name).read_bytes() == content
    run("generate", "--seed", 4, "--count", 1, "--first", 5, "--out", tmp_path / "one")
    (one,) = (tmp_path / "one").iterdir()
    assert one.read_bytes() == (tmp_path / "many" / one.name).read_bytes()
    assert run("check", tmp_path / "many").exit_code == 0


def test_generate_keeps_to_layouts(tmp_path):
    arguments = ("--seed", 1, "--count", 4, "--layout", "yard", "--format", "json")
    rows = json.loads(run("generate", *arguments, "--out", tmp_path).output)["scenarios"]
    assert {row["layout"] for row in rows} == {"yard"}


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("show", "nowhere"), "no file or scenario"),
        (("list", "--dataset", "nowhere"), "bundled dataset"),
        (("generate", "--seed", "1", "--count", "1", "--layout", "x", "--out", "o"), "no layout"),
    ],
)
def test_what_is_not_there_is_told_in_one_line(tmp_path, arguments, told):
    result = ct("scenarios", *arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert told in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_every_command_has_help_with_an_example():
    for name in scenarios.commands:
        assert "Example" in run(name, "--help").output, name
