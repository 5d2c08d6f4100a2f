from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from corpus_tools.cli.log_commands import log
from corpus_tools.logs.log_writing import write_log
from g3.errors import FormatError


@pytest.fixture
def path(tmp_path, driving):
    write_log(driving, tmp_path / "a.mcap", name="pick_up_tires", metadata={"seed": "7"})
    return str(tmp_path / "a.mcap")


def test_a_log_is_shown_to_people(path):
    shown = CliRunner().invoke(log, ["show", path], catch_exceptions=False).output.splitlines()
    assert shown == [
        "scenario  pick_up_tires",
        "duration  2.00 s, 5 moments",
        "robot     robot",
        "places    receiving",
        "seed: 7",
        "",
        "2 objects",
        "  robot  forklift, travels 1.00 m",
        "  tires  tire pallet, travels 1.30 m",
        "",
        "1 steps",
        "     0.50 to    2.00 s  pick_up tires",
    ]


def test_a_log_is_shown_to_programs(path):
    result = CliRunner().invoke(log, ["show", path, "--format", "json"], catch_exceptions=False)
    shown = json.loads(result.output)
    assert shown["scenario"] == "pick_up_tires"
    assert shown["duration_s"] == 2.0
    assert [item["id"] for item in shown["objects"]] == ["robot", "tires"]
    assert shown["steps"][0]["arguments"] == [["object", "tires"]]
    assert shown["metadata"] == {"seed": "7"}


def test_what_is_no_log_is_told(tmp_path):
    (tmp_path / "a.mcap").write_bytes(b"no log")
    with pytest.raises(FormatError, match="cut off, damaged or no MCAP"):
        CliRunner().invoke(log, ["show", str(tmp_path / "a.mcap")], catch_exceptions=False)
