"""Parts of videos are cut to the frame, when they are first watched."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import av
import pytest

from annotation_app.items.clips import clip_digest, ensure, is_clip
from annotation_app.items.media import digest
from annotation_app.study_setup.own_videos import own_videos
from annotation_app.study_setup.prepared_videos import check_readable, played_file, prepare
from corpus_tools.video import cutting
from corpus_tools.video import probe as probing
from corpus_tools.video.probe import probe
from g3.errors import CorpusError, FormatError
from tests.lerobot_datasets import film

GREYS = [20 + 4 * number for number in range(40)]  # four seconds


def greys(path: Path) -> list[int]:
    """The number of each frame of a video, by how bright it is."""
    with av.open(str(path)) as container:
        frames = container.decode(video=0)
        return [round((f.to_ndarray(format="rgb24").mean() - 20) / 4) for f in frames]


def cut(tmp_path: Path, start_s: float, end_s: float, codec: str = "libx264") -> Path:
    if codec == "libsvtav1":
        # As root, it gives the process that encodes real-time priority, and leaves it so.
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as own:
            own.submit(film, tmp_path / "long.mp4", GREYS, codec).result()
    else:
        film(tmp_path / "long.mp4", GREYS, codec)
    table = tmp_path / "parts.csv"
    table.write_text(f"video,id,start_s,end_s,episode\nlong.mp4,one,{start_s},{end_s},7\n")
    (item,) = own_videos(table)
    assert item.metadata == {"episode": "7"}
    file = played_file(item, prepare(item, tmp_path / "base"))
    assert is_clip(file)
    assert not file.exists()  # not before somebody watches it
    ensure(file)
    return file


@pytest.mark.parametrize("codec", ["libx264", "libsvtav1"])
@pytest.mark.parametrize(("start", "end"), [(10, 20), (0, 7), (11, 20), (10, 21), (30, 40)])
def test_a_part_has_its_frames_and_no_others(tmp_path: Path, start: int, end: int, codec: str):
    file = cut(tmp_path, start / 10, end / 10, codec)
    assert greys(file) == list(range(start, end))
    info = probe(file)
    assert info.duration_s == pytest.approx((end - start) / 10, abs=0.01)
    assert info.fps == 10


def test_it_is_known_before_it_is_cut_and_changes_with_the_part(tmp_path: Path):
    file = cut(tmp_path, 1.0, 2.0)
    before = file.stat().st_mtime_ns
    ensure(file)  # it is there
    assert file.stat().st_mtime_ns == before
    known = digest(file)
    assert known == clip_digest(file)
    file.unlink()
    assert digest(file) == known
    other = cut(tmp_path, 1.0, 2.2)
    assert other != file
    assert digest(other) != known
    assert greys(other) == list(range(10, 22))
    assert clip_digest(tmp_path / "long.mp4") is None


def test_a_video_that_has_gone_is_an_error(tmp_path: Path):
    file = cut(tmp_path, 1.0, 2.0)
    file.unlink()
    (tmp_path / "long.mp4").unlink()
    with pytest.raises(FormatError, match="can't be read"):
        ensure(file)
    assert [f.name for f in file.parent.iterdir() if f.suffix == ".mp4"] == []


def test_another_film_under_the_same_name_is_not_cut(tmp_path: Path):
    file = cut(tmp_path, 1.0, 2.0)
    film(tmp_path / "long.mp4", GREYS[::-1])
    ensure(file)  # what was cut before stays
    assert greys(file) == list(range(10, 20))
    file.unlink()
    with pytest.raises(FormatError, match=r"long\.mp4.*replaced"):
        ensure(file)
    assert not file.exists()


@pytest.mark.parametrize(
    ("start", "end"), [("1", ""), ("", "1"), ("2", "1"), ("-1", "1"), ("a", "b"), ("0", "inf")]
)
def test_parts_that_are_none(tmp_path: Path, start: str, end: str):
    film(tmp_path / "long.mp4", GREYS)
    table = tmp_path / "parts.csv"
    table.write_text(f"video,id,start_s,end_s\nlong.mp4,one,{start},{end}\n")
    with pytest.raises(CorpusError, match="no part of a video"):
        own_videos(table)


def test_parts_outside_of_the_file_are_named_by_their_rows(tmp_path: Path):
    film(tmp_path / "long.mp4", GREYS)
    table = tmp_path / "parts.csv"
    table.write_text("video,id,start_s,end_s\nlong.mp4,a,3,4.05\nlong.mp4,b,3,5\nlong.mp4,c,4,5\n")
    with pytest.raises(CorpusError) as caught:
        check_readable(own_videos(table))
    assert "parts.csv:2" not in str(caught.value)  # half a frame too long
    assert "parts.csv:3" in str(caught.value)
    assert "parts.csv:4" in str(caught.value)
    assert "4 s long" in str(caught.value)


def test_each_file_is_decoded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    film(tmp_path / "long.mp4", GREYS)
    rows = "".join(f"long.mp4,e{n},{n / 10},{(n + 5) / 10}\n" for n in range(30))
    table = tmp_path / "parts.csv"
    table.write_text(f"video,id,start_s,end_s\n{rows}")
    decoded: list[Path] = []
    decode = probing._decoded
    monkeypatch.setattr(
        probing, "_decoded", lambda file, *more: decoded.append(file) or decode(file, *more)
    )
    steps: list[str] = []
    for _ in range(2):
        probing._RECENT.clear()  # as in another process
        check_readable(own_videos(table), lambda step, _done, _of: steps.append(step))
        assert len(decoded) == 2  # and the part that was cut for a trial
    assert set(steps) == {"looking at long.mp4", "cutting a part of each video"}


def test_a_part_that_cannot_be_cut_is_named_before_anybody_watches(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    film(tmp_path / "long.mp4", GREYS)
    table = tmp_path / "parts.csv"
    table.write_text("video,id,start_s,end_s\nlong.mp4,a,0.5,0.9\nlong.mp4,b,0,4\n")
    # As in a build of PyAV without the encoder.
    monkeypatch.setitem(cutting.ENCODERS, "mp4", ("no-such-encoder", {}))
    with pytest.raises(CorpusError, match=r"long\.mp4"):
        check_readable(own_videos(table))
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    check_readable(own_videos(table))


@pytest.fixture(autouse=True)
def _priority() -> Iterator[None]:
    """Tests that run later would starve others."""
    before = os.sched_getscheduler(0)
    yield
    assert os.sched_getscheduler(0) == before
