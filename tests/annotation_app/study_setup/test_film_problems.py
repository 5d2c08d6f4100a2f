"""Films that people couldn't watch as they are meant are named before anybody is asked."""

from __future__ import annotations

import csv
import io
import json
import shutil
import unicodedata
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flask import Flask

from annotation_app.cli import served_studies
from annotation_app.core.config import open_instance
from annotation_app.study_setup.own_videos import own_videos
from corpus_tools.cli.console import run
from corpus_tools.tables.curve_file import Curve, write_curves
from corpus_tools.video.probe import probe
from g3.errors import CorpusError
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.study_setup.test_own_videos import export, set_up
from tests.shared_cases import case
from tests.small_films import cut_off, film, numbers

STUDY: dict[str, Any] = {
    "name": "arm",
    "title": "An arm",
    "videos": "clips",
    "tasks": {task: {"practice": False} for task in ("describe", "segment")},
}


def study(folder: Path, **more: Any) -> Path:
    file = folder / "arm.yaml"
    file.write_text(json.dumps(STUDY | more))
    return file


def check(file: Path) -> int:
    return run(["annotate", "check", str(file), "--instance", str(file.parent / "instance")])


def shown(app: Flask, worker: Browser, folder: Path) -> tuple[dict[str, Any], Path]:
    """What the page of a worker's next video has, and the file that is played there."""
    page = worker.lease("describe", "arm").json
    with worker.client.get(f"/media/{page['payload']['video']}") as response:
        assert response.status_code == 200
        played = folder / f"played.{response.mimetype.split('/')[1]}"
        played.write_bytes(response.data)
    return page, played


@pytest.mark.parametrize(
    ("name", "more", "length_s"),
    [
        ("recorded.webm", {"is_piped": True}, 2),
        ("late.mp4", {"times": [1.5 + n / 10 for n in range(20)]}, 2),
        ("sound.mp4", {"sound_s": 4}, 2),
        ("pauses.mp4", {"times": [0, 0.1, 1.4], "last_s": 0.6}, 2),
        ("plain.mp4", {}, 2),
    ],
)
def test_manifest_page_and_film_have_one_length(
    tmp_path: Path, name: str, more: dict[str, Any], length_s: float
):
    film(tmp_path / "clips" / name, more.pop("times", 20), **more)
    with set_up(study(tmp_path)) as app:
        page, played = shown(app, Browser(app, study="arm"), tmp_path)
    assert page["payload"]["duration_s"] == pytest.approx(length_s)
    info = probe(played)
    assert info.first_time_s == 0
    assert info.duration_s == pytest.approx(length_s, abs=0.002)
    assert info.stated_s == pytest.approx(length_s, abs=0.1)


def test_a_part_of_any_film_plays(tmp_path: Path):
    films = tmp_path / "films"
    film(films / "a.webm", 20, sound_s=2)
    film(films / "b.webm", 20, is_piped=True)
    film(films / "c.mp4", [n / 10 + (2 if n > 9 else 0) for n in range(20)])
    film(films / "d.mp4", 20, turned=90, aspect=Fraction(3, 2))
    film(films / "e.mp4", [1.5 + n / 10 for n in range(20)])
    rows = [f"films/{f.name},{f.stem},0.5,1.5" for f in sorted(films.iterdir())]
    (tmp_path / "t.csv").write_text("video,id,start_s,end_s\n" + "\n".join(rows))
    file = study(tmp_path, videos="t.csv")
    assert check(file) == 0
    with set_up(file) as app:
        worker = Browser(app, study="arm")
        for _ in rows:
            page, played = shown(app, worker, tmp_path)
            assert page["payload"]["duration_s"] == pytest.approx(1)
            assert probe(played).duration_s == pytest.approx(1, abs=0.002)
            assert worker.answer(page["item"], described()).status_code == 200


@pytest.mark.parametrize(
    ("name", "more", "told"),
    [
        ("half.mp4", {"keys": 4}, "half.mp4: the video isn't whole: it is cut off"),
        ("half.webm", {"keys": 4}, "half.webm: the video isn't whole: it is cut off"),
        ("fine.mp4", {"pixels": "yuv444p"}, "browsers don't play"),
        ("ten.mp4", {"pixels": "yuv420p10le"}, "browsers don't play"),
        ("other.webm", {"kind": "matroska", "codec": "libx264"}, "browsers don't play"),
    ],
)
def test_what_can_not_be_watched_is_named(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    name: str,
    more: dict[str, Any],
    told: str,
):
    path = film(tmp_path / "clips" / name, 30, **more)
    if name.startswith("half"):
        cut_off(path, 0.5)
    file = study(tmp_path)
    assert check(file) == 2
    assert told in capsys.readouterr().out
    assert run(["annotate", "init", str(tmp_path / "x.yaml"), "--videos", str(path.parent)]) == 2
    assert told in capsys.readouterr().err
    with pytest.raises(CorpusError, match=name), set_up(file):
        pass


def test_a_part_beyond_the_end_names_its_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    film(tmp_path / "a.mp4", 20)
    rows = "video,id,start_s,end_s\na.mp4,one,1,2\na.mp4,two,1,3\n"
    (tmp_path / "t.csv").write_text(rows)
    assert check(study(tmp_path, videos="t.csv")) == 2
    found = capsys.readouterr().out
    assert "t.csv:3" in found
    assert "t.csv:2" not in found


@pytest.mark.parametrize("is_part", [False, True])
def test_another_film_under_the_same_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], is_part: bool
):
    clip = film(tmp_path / "clips/push.mp4", 20)
    if is_part:
        (tmp_path / "t.csv").write_text("video,id,start_s,end_s\nclips/push.mp4,push,0.5,1.5\n")
    file = study(tmp_path, videos="t.csv") if is_part else study(tmp_path)
    old = clip.read_bytes()
    with set_up(file) as app:
        worker = Browser(app, study="arm")
        page, _ = shown(app, worker, tmp_path)
        assert worker.answer(page["item"], described("Push the cup.")).status_code == 200
        before = json.loads(export(file, "jsonl").read_text())["video_sha256"]
        film(clip, 30)
        name = page["payload"]["video"]
        with worker.client.get(f"/media/{name}") as played:
            if is_part:  # cut before, it is what people were asked about
                (tmp_path / "again.mp4").write_bytes(played.data)
                assert numbers(tmp_path / "again.mp4") == list(range(5, 15))
            else:
                assert played.status_code == 404
    for files in ([str(file)], []):
        capsys.readouterr()
        assert run(["annotate", "check", *files, "--instance", str(tmp_path / "instance")]) == 2
        assert "'push'" in (found := capsys.readouterr().out)
        assert "replaced" in found
    with pytest.raises(CorpusError, match=r"push.*replaced"), set_up(file):
        pass
    rows = list(csv.DictReader(io.StringIO(export(file, "csv").read_text())))
    assert [row["video_sha256"] for row in rows] == [before]
    clip.write_bytes(old)
    assert check(file) == 0
    with set_up(file) as app, Browser(app, study="arm").client.get(f"/media/{name}") as played:
        assert played.status_code == 200


def test_the_film_of_a_further_camera_is_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    film(tmp_path / "a.mp4", 20)
    further = film(tmp_path / "b.mp4", 20)
    (tmp_path / "t.csv").write_text("video,id,video_2,camera_2\na.mp4,push,b.mp4,wrist\n")
    told = ["annotate", "check", "--instance", str(tmp_path / "instance")]
    file = study(tmp_path, videos="t.csv")
    with set_up(file) as app:
        worker = Browser(app, study="arm")
        page, _ = shown(app, worker, tmp_path)
        assert worker.answer(page["item"], described("Push the cup.")).status_code == 200
    run(told)
    assert "b.mp4" not in capsys.readouterr().out
    film(further, 30)
    assert run(told) == 2
    assert f"{further} has been replaced" in capsys.readouterr().out
    with pytest.raises(CorpusError, match=r"b\.mp4.*push.*replaced"), set_up(file):
        pass


def test_curves_beside_the_films_of_a_folder(tmp_path: Path):
    """They are named like the film; a damaged file is named before anybody is asked."""
    for name in ("lift", "push"):
        film(tmp_path / f"clips/{name}.mp4", 20)
    curves = tmp_path / "clips/push.safetensors"
    values = np.arange(20, dtype=np.float32).reshape(20, 1)
    write_curves(curves, [Curve("state", "x")], 10.0, 20, iter([values]))
    lift, push = own_videos(tmp_path / "clips")
    assert (lift.curves, push.curves) == (None, curves)
    with set_up(study(tmp_path)) as app:
        worker = Browser(app, study="arm")
        beside = {}
        for _ in range(2):
            page = worker.lease("describe", "arm").json
            beside[page["item"]] = page["payload"].get("beside")
            worker.answer(page["item"], described("Push the cup."))
        assert len(beside) == 2
        (of_push,) = filter(None, beside.values())
        with worker.client.get(f"/media/{of_push['curves']}") as sent:
            assert sent.data == curves.read_bytes()
    curves.write_bytes(curves.read_bytes()[:50])
    assert check(study(tmp_path)) == 2


def test_a_film_is_replaced_before_anybody_is_asked(tmp_path: Path):
    clip = film(tmp_path / "clips/push.mp4", 20)
    file = study(tmp_path)
    with set_up(file):
        pass
    film(clip, 30)
    with set_up(file) as app:
        page, played = shown(app, Browser(app, study="arm"), tmp_path)
    assert page["payload"]["duration_s"] == 3
    assert probe(played).duration_s == 3


def test_an_installation_is_checked_without_its_study_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    clip = film(tmp_path / "clips/push.mp4", 20)
    file = study(tmp_path)
    with set_up(file):
        pass
    clip.unlink()
    call = ["annotate", "check", "--instance", str(tmp_path / "instance")]
    assert run(call) == 2
    assert str(clip) in capsys.readouterr().out


def test_the_first_set_up_page_names_a_film_that_is_cut_off(tmp_path: Path):
    config = open_instance(tmp_path / "instance")
    cut_off(film(tmp_path / "clips/half.mp4", 30, keys=4), 0.6)
    with pytest.raises(CorpusError, match="cut off"):
        served_studies.put_file(config, study(tmp_path))


@pytest.mark.parametrize(
    ("name", "length_s"),
    [("02-vp8-part", 2), ("03-vfr-part", 4), ("12-rotated", 2), ("14-start-offset", 2)],
)
def test_studies_of_parts_of_others(tmp_path: Path, name: str, length_s: float):
    folder = tmp_path / "case"
    shutil.copytree(case(name), folder)
    folder.chmod(0o755)
    file = tmp_path / "arm.yaml"
    file.write_text(json.dumps(STUDY | {"videos": "case/t.csv"}))
    assert check(file) == 0
    with set_up(file) as app:
        page, played = shown(app, Browser(app, study="arm"), tmp_path)
    assert page["payload"]["duration_s"] == pytest.approx(length_s, abs=0.05)
    assert probe(played).duration_s == pytest.approx(page["payload"]["duration_s"], abs=0.01)


def test_a_study_of_a_telephones_film_with_upright_boxes(tmp_path: Path):
    folder = tmp_path / "case"
    shutil.copytree(case("12-rotated"), folder)
    folder.chmod(0o755)
    assert check(folder / "st.yaml") == 0


def test_half_a_film_of_others(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "clips").mkdir()
    shutil.copy(case("15-cut-off-faststart/half.mp4"), tmp_path / "clips")
    assert check(study(tmp_path)) == 2
    assert "cut off" in capsys.readouterr().out


def test_a_replaced_film_is_noticed_whatever_form_its_name_has(tmp_path: Path):
    composed, apart = (unicodedata.normalize(form, "café") for form in ("NFC", "NFD"))
    clip = film(tmp_path / f"clips/{composed}.mp4", 20)
    file = study(tmp_path)
    with set_up(file) as app:
        worker = Browser(app, study="arm")
        page, _ = shown(app, worker, tmp_path)
        assert worker.answer(page["item"], described("Push the cup.")).status_code == 200
    clip.unlink()
    film(tmp_path / f"clips/{apart}.mp4", 30)
    with pytest.raises(CorpusError, match="replaced"), set_up(file):
        pass
