"""Crops of kinds of things, and the study in which people name them."""

from __future__ import annotations

import csv
import json

import cv2
import pytest

from corpus_tools.cli.console import run
from corpus_tools.world.looks.site_looks import SITES
from corpus_tools.world.scenarios.scenario import SiteName


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("naming") / "sheet"
    assert run(["scenarios", "naming-sheet", "crate", "forklift", "--out", str(out)]) == 0
    return out


def test_each_kind_is_cut_out_as_each_camera_sees_it(made):
    with (made / "things.csv").open() as file:
        rows = list(csv.DictReader(file))
    seen = {(row["kind"], row["camera"]) for row in rows}
    assert seen == {
        ("crate", "overview"),
        ("crate", "follow"),
        ("crate", "operator"),
        ("forklift", "overview"),
        ("forklift", "follow"),
    }
    for row in rows:
        assert int(row["width_px"]) > 30
        assert int(row["height_px"]) > 30
        assert (made / row["video"]).read_bytes()[4:8] == b"ftyp"
        assert row["kind"] not in row["video"]
    page = cv2.imread(str(made / "naming-sheet.jpg"))
    assert page.std() > 20


def test_the_study_can_be_started(made, capsys):
    assert run(["annotate", "check", str(made / "study.yaml")]) == 0, capsys.readouterr()


def test_unknown_kinds_are_refused(tmp_path, capsys):
    assert run(["scenarios", "naming-sheet", "dragon", "--out", str(tmp_path / "x"), "--json"]) == 2
    assert "there is no kind 'dragon'" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


def test_layouts_can_name_every_site():
    assert set(SiteName.__args__) == set(SITES)


def test_the_result_can_be_read_by_programs(tmp_path, capsys):
    out = str(tmp_path / "one")
    assert run(["scenarios", "naming-sheet", "cone", "--out", out, "--json"]) == 0
    things = json.loads(capsys.readouterr().out)["things"]
    assert [thing["camera"] for thing in things] == ["overview", "follow", "operator"]
