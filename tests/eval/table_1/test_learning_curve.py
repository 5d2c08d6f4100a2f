from __future__ import annotations

import csv
import math
import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eval.table_1.correspondence import ROW_TYPES
from eval.table_1.learning_curve import CurvePoint, spread, write_csv, write_plot
from g3.errors import FormatError

POINTS = tuple(
    CurvePoint(kind, sdcs, error, error - 0.02, error + 0.02)
    for level, kind in enumerate(ROW_TYPES)
    for sdcs, error in ((2000, 0.1 + level / 50), (500, 0.3 + level / 50))
)
NAN_POINT = CurvePoint("PATH", 100, math.nan, math.nan, math.nan)


def test_csv_is_ordered_and_records_metadata(tmp_path):
    path = tmp_path / "curve.csv"
    write_csv([NAN_POINT, *POINTS], path, metadata={"seed": 3})
    with path.open(newline="") as file:
        records = list(csv.DictReader(file))
    order = [(ROW_TYPES.index(record["type"]), int(record["sdcs"])) for record in records]
    assert order == sorted(order)
    assert {record["seed"] for record in records} == {"3"}
    assert [record["error"] for record in records if record["sdcs"] == "100"] == [""]


def test_csv_of_no_points_has_its_header(tmp_path):
    write_csv([], tmp_path / "curve.csv")
    assert (tmp_path / "curve.csv").read_text() == "type,sdcs,error,low,high,reason\n"


@pytest.mark.parametrize(
    "points", [(), POINTS, POINTS[:1], (NAN_POINT,), (NAN_POINT, *POINTS)], ids=repr
)
def test_png_of_any_points(tmp_path, points):
    path = tmp_path / "curve.PNG"
    write_plot(points, path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert [p.name for p in tmp_path.iterdir()] == ["curve.PNG"]


def test_svg_says_what_it_shows(tmp_path):
    path = tmp_path / "curve.svg"
    write_plot(POINTS, path, metadata={"seed": 3}, bounds="range of 5 draws")
    words = " ".join(text.strip() for text in ET.parse(path).getroot().itertext() if text.strip())
    for expected in (
        "Annotated SDCs trained on",
        "Test error (bands: range of 5 draws)",
        "1,000 SDCs",
        "Overall",
        "seed: 3",
    ):
        assert expected in words


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_the_same_points_give_the_same_file(tmp_path, suffix):
    one, two = tmp_path / f"one{suffix}", tmp_path / f"two{suffix}"
    write_plot(POINTS, one)
    write_plot(POINTS[::-1], two)
    assert one.read_bytes() == two.read_bytes()


@pytest.mark.parametrize("name", ["curve.eps", "curve"])
def test_other_suffixes_are_refused(tmp_path, name):
    with pytest.raises(FormatError, match=r"end the name in \.png or \.svg or \.pdf"):
        write_plot(POINTS, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_told(tmp_path):
    with pytest.raises(FormatError, match="there is no such folder"):
        write_csv(POINTS, tmp_path / "nowhere" / "curve.csv")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "curve.csv"
    path.write_text("old")

    def fail(_):
        raise OSError("disk full")

    monkeypatch.setattr("os.fsync", fail)
    with pytest.raises(OSError, match="disk full"):
        write_csv(POINTS, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_matplotlib_is_imported_only_to_plot():
    code = "import sys, eval.table_1.learning_curve; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_crowded_names_share_the_room_about_their_mean():
    assert spread([0.5, 0.5], 0.1) == pytest.approx([0.45, 0.55])
    assert spread([0.1, 0.5, 0.52], 0.1) == pytest.approx([0.1, 0.46, 0.56])
    assert spread([], 0.1) == []


@given(st.lists(st.floats(0, 1), max_size=8).map(sorted), st.floats(0.001, 0.2))
def test_spread_keeps_a_gap_and_the_mean(heights, gap):
    apart = spread(heights, gap)
    assert all(b - a >= gap - 1e-9 for a, b in pairwise(apart))
    assert sum(apart) == pytest.approx(sum(heights), abs=1e-9)
