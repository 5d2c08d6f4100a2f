from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from corpus_tools.cli.console import run
from corpus_tools.logs.log_reading import read_log
from corpus_tools.video.drawing.drawn_moments import sampled
from corpus_tools.video.items import context_items, story_of
from tests.tiny_corpus import tiny_corpus

CT = Path(sys.executable).with_name("ct")
FILES = {
    "log.mcap",
    "manifest.json",
    "poster.png",
    "segmentation.json",
    "segmentation.png",
    "video.mp4",
}
NAMES = ["put_on_truck-world", "to_pallet-world", "to_truck-world"]
FAST = ("--size", "160x120", "--fps", "4", "--quality", "draft")
LONG = ("--size", "160x120", "--fps", "40", "--quality", "draft")
"""So many frames that there is time to stop it."""


@dataclass(frozen=True)
class Run:
    returncode: int
    stdout: str
    stderr: str


def render(*args) -> Run:
    with redirect_stdout(StringIO()) as stdout, redirect_stderr(StringIO()) as stderr:
        code = run(["render-videos", *map(str, args)])
    return Run(code, stdout.getvalue(), stderr.getvalue())


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("corpora") / "tiny"
    tiny_corpus().save(folder)
    return folder


@pytest.fixture(scope="module")
def rendered(corpus, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "videos"
    result = render("--corpus", corpus, "--out", out, *FAST)
    assert result.returncode == 0, result.stderr
    assert result.stdout == "rendered 3\n"
    return out


def test_a_scenario_is_rendered_without_knowledge_of_words(tmp_path):
    code = (
        "import sys; from corpus_tools.cli.console import run\n"
        f"status = run(['render-videos', 'dock_pick_up_tires', '--out', 'out', *{FAST}])\n"
        "of_words = ('g3.language', 'g3.features', 'g3.inference')\n"
        "sys.exit(status or any(name.startswith(of_words) for name in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, cwd=tmp_path)
    assert done.returncode == 0


def test_each_gets_a_folder_with_all_files(rendered):
    assert sorted(path.name for path in rendered.iterdir()) == NAMES
    for name in NAMES:
        assert {path.name for path in (rendered / name).iterdir()} == FILES


def test_the_manifest_tells_the_files(rendered):
    folder = rendered / NAMES[1]
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["id"] == "to_pallet/world"
    assert manifest["settings"] == {
        "camera": "track",
        "fps": 4,
        "names": False,
        "quality": "draft",
        "size": [160, 120],
        "skip_idle": False,
        "speed": 1.0,
    }
    # 33 frames at 4 a second: the video's times are the log's.
    assert manifest["clock"] == [[0.0, 0.0], [8.25, 8.25]]
    assert set(manifest["files"]) == FILES - {"manifest.json"}
    for name, file in manifest["files"].items():
        data = (folder / name).read_bytes()
        assert file == {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    assert np.shape(manifest["camera"]["extrinsics"]) == (3, 4)


def test_the_video_is_as_the_manifest_says(rendered):
    folder = rendered / NAMES[1]
    manifest = json.loads((folder / "manifest.json").read_text())
    # The tiny corpus's robot drives for 8 seconds.
    assert manifest["frames"] == 33
    with av.open(str(folder / "video.mp4")) as container:
        stream = container.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert stream.average_rate == 4
    assert len(frames) == 33
    assert frames[0].shape == (120, 160, 3)
    poster = cv2.imread(str(folder / "poster.png"))[..., ::-1]
    assert poster.std() > 10
    middle = max(cv2.PSNR(frame, np.ascontiguousarray(poster)) for frame in frames)
    assert middle > 28
    # Its index comes first, so that it plays before it is loaded.
    data = (folder / "video.mp4").read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")


def test_a_faster_video_tells_the_times_of_its_log(corpus, rendered, tmp_path):
    result = render(
        "--corpus", corpus, "--only", NAMES[1], "--out", tmp_path, "--speed", "2", *FAST
    )
    assert result.returncode == 0, result.stderr
    manifest = json.loads((tmp_path / NAMES[1] / "manifest.json").read_text())
    assert manifest["frames"] == 17  # 8 s in 4, at 4 frames a second
    assert manifest["duration_s"] == 4.25
    assert manifest["clock"] == [[0.0, 0.0], [4.25, 8.5]]
    log = (tmp_path / NAMES[1] / "log.mcap").read_bytes()
    assert log == (rendered / NAMES[1] / "log.mcap").read_bytes()


def test_the_log_holds_what_the_video_shows(rendered):
    log = read_log(rendered / NAMES[1] / "log.mcap")
    assert len(sampled(log.recording, 4).t_ns) == 33
    assert log.name == "to_pallet/world"


def test_the_segmentation_fits_its_description(rendered):
    folder = rendered / NAMES[1]
    image = cv2.imread(str(folder / "segmentation.png"), cv2.IMREAD_UNCHANGED)
    told = json.loads((folder / "segmentation.json").read_text())
    assert image.shape == (told["height"], told["width"]) == (120, 160)
    by_id = {item["id"]: item for item in told["objects"]}
    assert by_id["pallet"]["labels"] == ["tire", "pallet"]
    for item in told["objects"]:
        assert (image == item["value"]).sum() == item["pixels"]
    assert by_id["forklift"]["pixels"] > 20


def test_what_is_finished_is_skipped(rendered, corpus):
    before = contents(rendered)
    (rendered / NAMES[0] / "poster.png").write_bytes(b"damaged")
    (rendered / NAMES[2] / "manifest.json").unlink()
    (rendered / NAMES[2] / "log.mcap").unlink()
    for path in (rendered / NAMES[2]).iterdir():
        path.unlink()
    result = render("--corpus", corpus, "--out", rendered, *FAST)
    assert result.stdout == "skipped 1, rendered 2\n", result.stderr
    assert contents(rendered) == before
    told = json.loads(render("--corpus", corpus, "--out", rendered, *FAST, "--json").stdout)
    assert told == {"folder": str(rendered), "skipped": NAMES, "rendered": [], "failed": {}}


def test_several_jobs_make_the_same_files(rendered, corpus, tmp_path):
    result = render("--corpus", corpus, "--out", tmp_path, *FAST, "--jobs", "2")
    assert result.stdout == "rendered 3\n", result.stderr
    assert contents(tmp_path) == contents(rendered)


def test_only_and_force(rendered, corpus):
    args = ("--corpus", corpus, "--out", rendered, *FAST, "--only", "to_t*", "--force")
    assert render(*args).stdout == "rendered 1\n"


def test_other_settings_are_another_input(corpus, rendered):
    args = ("--corpus", corpus, "--out", rendered, "--only", "to_t*", *FAST[:4])
    assert render(*args, "--camera", "follow").stdout == "rendered 1\n"
    assert render(*args, "--camera", "follow").stdout == "skipped 1\n"
    assert render(*args, "--quality", "draft").stdout == "rendered 1\n"


def test_other_colours_are_another_input(corpus, tmp_path):
    tiny = tiny_corpus()
    name, context = next(iter(tiny.contexts.items()))
    painted = tuple(replace(item, colours=("red",)) for item in context.objects)
    contexts = {**tiny.contexts, name: replace(context, objects=painted)}
    replace(tiny, contexts=contexts).save(tmp_path / "painted")
    one, other = (
        {item.name: story_of(item).fingerprint for item in context_items(str(folder))}
        for folder in (corpus, tmp_path / "painted")
    )
    assert [key for key in one if one[key] != other[key]] == [name.replace("/", "-")]


def test_a_killed_run_leaves_nothing_that_looks_finished(corpus, tmp_path):
    args = ("--corpus", str(corpus), "--out", str(tmp_path), *LONG)
    process = subprocess.Popen([CT, "render-videos", *args], stdout=subprocess.DEVNULL)
    give_up = time.monotonic() + 120
    # Killed while the second is under way.
    while not (tmp_path / NAMES[0]).exists() or not list(tmp_path.glob(f".{NAMES[1]}*/*.mp4")):
        assert process.poll() is None
        assert time.monotonic() < give_up
        time.sleep(0.01)
    process.kill()
    process.wait()
    visible = [path.name for path in tmp_path.iterdir() if not path.name.startswith(".")]
    assert visible == NAMES[:1]
    assert {path.name for path in (tmp_path / NAMES[0]).iterdir()} == FILES
    assert render(*args, "--only", "*p*").stdout == "skipped 1, rendered 1\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == NAMES[:2]


def test_control_c_ends_all_processes_with_one_line(corpus, tmp_path):
    args = ("--corpus", str(corpus), "--out", str(tmp_path), *LONG, "--jobs", "2")
    process = subprocess.Popen(
        [CT, "render-videos", *args],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    give_up = time.monotonic() + 120
    while not list(tmp_path.glob(".*/*.mp4")):
        assert process.poll() is None
        assert time.monotonic() < give_up
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    (line,) = told.strip().splitlines()
    assert line.startswith(f"ct: interrupted: {tmp_path} isn't finished")


def test_one_that_fails_does_not_stop_the_others(corpus, tmp_path):
    (tmp_path / NAMES[1]).mkdir()
    (tmp_path / NAMES[1] / "letter.txt").write_text("mine")
    result = render("--corpus", corpus, "--out", tmp_path, *FAST, "--only", "to_*")
    assert result.returncode == 2
    assert result.stdout == "rendered 1, failed 1\n"
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"ct: {NAMES[1]}: ")
    assert (tmp_path / NAMES[1] / "letter.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (["no_such_scenario", "--out", "out"], "no_such_scenario"),
        (["--out", "out", "--size", "641x480"], "641x480"),
        (["--out", "out", "--size", "large"], "large"),
        (["--out", "out", "--camera", "drone"], "drone"),
        (["--out", "/proc/videos"], "/proc/videos"),
        (["--corpus", "no_such_corpus", "--out", "out"], "no_such_corpus"),
        (["--out", "out", "--only", "nothing*"], "no name like 'nothing*'"),
        (["one", "--corpus", "two", "--out", "out"], "either"),
    ],
)
def test_wrong_input_is_told_in_a_line(args, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = render(*args)
    assert result.returncode == 2
    assert told in result.stderr
    assert "Traceback" not in result.stderr
