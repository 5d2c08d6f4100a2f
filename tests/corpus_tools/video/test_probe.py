"""Videos are what they decode to, whatever their headers say."""

from __future__ import annotations

import os
import shutil
import time
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from numpy.testing import assert_allclose

from corpus_tools.video import probe as probing
from corpus_tools.video.probe import file_digest, probe
from g3.errors import FormatError
from tests.shared_cases import case
from tests.small_films import cut_off, film, write_tone

ENDLESS_S = 3 * 365 * 24 * 3600


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, on the disk and in the process."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    probing._RECENT.clear()
    return tmp_path / "cache/corpus-tools-g3/videos"


@pytest.fixture
def decoded(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files that were decoded."""
    files: list[Path] = []
    decode = probing._decoded
    monkeypatch.setattr(
        probing, "_decoded", lambda file, *more: files.append(file) or decode(file, *more)
    )
    return files


def test_a_recording_without_a_stated_length(tmp_path: Path):
    info = probe(film(tmp_path / "a.webm", 12, is_piped=True))
    assert (info.stated_s, info.duration_s) == (0, 1.2)
    assert_allclose(info.frame_times, np.arange(12) / 10)
    assert (info.codec, info.container, info.problem) == ("vp8", "webm", "")
    assert info.is_playable


def test_frames_have_their_own_times(tmp_path: Path):
    times = [0, 0.1, 0.2, 1.7, 1.75, 3.0]
    for name in ("a.mp4", "a.webm"):
        info = probe(film(tmp_path / name, times, last_s=0.5))
        assert_allclose(info.frame_times, times, atol=1e-9)
        assert info.fps == pytest.approx(5 / 3, abs=1e-3)
    info = probe(film(tmp_path / "b.mp4", times, last_s=0.5))
    assert info.duration_s == pytest.approx(3.5)  # the last frame stays for half a second


@pytest.mark.parametrize("start_s", [1.5, ENDLESS_S])
@pytest.mark.parametrize("name", ["late.mp4", "late.webm"])
def test_the_first_frame_is_at_0(tmp_path: Path, name: str, start_s: float):
    info = probe(film(tmp_path / name, [start_s + n / 10 for n in range(10)]))
    assert info.first_time_s == pytest.approx(start_s)
    assert_allclose(info.frame_times, np.arange(10) / 10, atol=1e-9)
    assert info.duration_s == pytest.approx(1)


def test_a_single_frame(tmp_path: Path):
    info = probe(film(tmp_path / "a.mp4", 1, last_s=2))
    assert (len(info.frame_times), info.duration_s, info.fps) == (1, 2, 0.5)


def test_b_frames_are_in_the_order_of_their_times(tmp_path: Path):
    info = probe(film(tmp_path / "a.mp4", 20, options={"bf": "3"}))
    assert_allclose(info.frame_times, np.arange(20) / 10)
    unshifted = {"movflags": "+faststart", "use_editlist": "0"}
    info = probe(film(tmp_path / "b.mp4", 20, options={"bf": "3"}, muxed=unshifted))
    assert_allclose(info.frame_times, np.arange(20) / 10)
    assert info.first_time_s > 0


@pytest.mark.parametrize("turned", [0, 90, 180, 270])
def test_the_size_is_what_people_see(tmp_path: Path, turned: int):
    info = probe(film(tmp_path / "a.mp4", 2, turned=turned, aspect=Fraction(3, 2)))
    assert info.rotation == turned
    assert info.pixel_aspect == Fraction(3, 2)
    assert (info.width, info.height) == ((96, 48) if turned % 180 == 0 else (48, 96))
    assert not info.is_mirrored


def test_mirrored_and_narrow_pixels(tmp_path: Path):
    info = probe(film(tmp_path / "a.mp4", 2, is_mirrored=True, aspect=Fraction(1, 2)))
    assert (info.is_mirrored, info.rotation, info.width, info.height) == (True, 0, 64, 96)


def test_sound_may_be_longer_than_the_pictures(tmp_path: Path):
    info = probe(film(tmp_path / "a.mp4", 10, sound_s=2))
    assert info.has_audio
    assert info.duration_s == 1
    assert info.stated_s == pytest.approx(2, abs=0.1)
    assert not info.problem


@pytest.mark.parametrize(
    ("name", "more", "is_playable"),
    [
        ("a.mp4", {}, True),
        ("a.mp4", {"pixels": "yuv444p"}, False),
        ("a.mp4", {"codec": "libx264", "pixels": "yuv420p10le"}, False),
        ("a.mp4", {"codec": "mpeg4"}, False),
        ("a.mp4", {"codec": "libvpx-vp9"}, True),
        ("a.webm", {"codec": "libvpx-vp9"}, True),
        ("a.webm", {"codec": "libvpx-vp9", "pixels": "yuva420p"}, True),
        ("a.webm", {"kind": "matroska"}, False),
        ("a.webm", {"kind": "matroska", "codec": "libx264"}, False),
    ],
)
def test_what_browsers_play(tmp_path: Path, name: str, more: dict[str, str], is_playable: bool):
    info = probe(film(tmp_path / name, 3, **more))
    assert info.is_playable == is_playable
    assert not info.problem
    assert len(info.frame_times) == 3


@pytest.mark.parametrize("share", [0.5, 0.95])
@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("faststart.mp4", {}),
        ("fragments.mp4", {"muxed": {"movflags": "frag_keyframe+empty_moov"}}),
        ("whole.webm", {}),
        ("piped.webm", {"is_piped": True}),
    ],
)
def test_a_file_that_is_cut_off(tmp_path: Path, name: str, more: dict[str, object], share: float):
    path = film(tmp_path / name, 40, keys=4, **more)
    assert not probe(path).problem
    info = probe(cut_off(path, share))
    assert "cut off" in info.problem
    assert 0 < len(info.frame_times) < 40


def test_no_index_is_no_video(tmp_path: Path):
    path = cut_off(film(tmp_path / "a.mp4", 20, muxed={}), 0.6)  # the index was at the end
    with pytest.raises(FormatError, match=r"a\.mp4"):
        probe(path)


def test_damage_in_the_middle_and_what_follows_the_end(tmp_path: Path):
    path = film(tmp_path / "a.mp4", 40, options={"crf": "1"})
    whole = path.read_bytes()
    path.write_bytes(whole + b"\x17" * 5000)
    assert not probe(path).problem
    at = whole.index(b"mdat") + len(whole[whole.index(b"mdat") :]) // 2
    path.write_bytes(whole[:at] + b"\xff" * 300 + whole[at + 300 :])
    assert "damaged" in probe(path).problem
    assert probe(path).duration_s == pytest.approx(4, abs=0.2)


def test_a_tail_of_zeros(tmp_path: Path):
    for name in ("a.mp4", "a.webm"):
        path = film(tmp_path / name, 40, options={"crf": "4"})
        content = path.read_bytes()
        half = len(content) // 2
        path.write_bytes(content[:half] + bytes(len(content) - half))
        assert probe(path).problem


def test_a_cover_picture_is_no_video(tmp_path: Path):
    plain, path = film(tmp_path / "plain.mp4", 12), tmp_path / "cover.mp4"
    with av.open(str(plain)) as source, av.open(str(path), "w") as out:
        cover = out.add_stream("png", rate=1)
        cover.width, cover.height, cover.pix_fmt = 20, 20, "rgb24"
        cover.disposition = av.stream.Disposition.attached_pic
        video = out.add_stream_from_template(source.streams.video[0], opaque=True)
        out.mux(cover.encode(av.VideoFrame(20, 20, "rgb24")))
        out.mux(cover.encode(None))
        for packet in source.demux(video=0):
            if packet.dts is not None:
                packet.stream = video
                out.mux(packet)
    info = probe(path)
    assert (info.codec, info.width, len(info.frame_times)) == ("h264", 64, 12)


@pytest.mark.parametrize(
    "content", [b"", b"This is no video.", b"ffconcat version 1.0\nfile a.mp4"]
)
def test_other_files(tmp_path: Path, content: bytes):
    film(tmp_path / "a.mp4", 2)
    (tmp_path / "b.mp4").write_bytes(content)
    with pytest.raises(FormatError, match=r"b\.mp4"):
        probe(tmp_path / "b.mp4")


def test_only_sound_a_folder_a_pipe_and_nothing(tmp_path: Path):
    path = tmp_path / "sound.mp4"
    with av.open(str(path), "w") as out:
        stream = out.add_stream("aac", rate=48_000)
        write_tone(out, stream, 0.3)
    os.mkfifo(tmp_path / "pipe.mp4")
    for file in (path, tmp_path, tmp_path / "pipe.mp4", tmp_path / "none.mp4"):
        with pytest.raises(FormatError):
            probe(file)


def test_a_second_look_costs_nothing(tmp_path: Path, decoded: list[Path]):
    path = film(tmp_path / "a.mp4", 20)
    shares: list[float] = []
    first = probe(path, progress=shares.append)
    assert shares[-1] == 1
    assert shares == sorted(shares)
    probing._RECENT.clear()  # as in another process
    again = probe(path, progress=shares.clear)  # type: ignore[arg-type]
    assert shares
    assert len(decoded) == 1
    assert_allclose(again.frame_times, first.frame_times)
    names = (name for name in type(first).__slots__ if name != "frame_times")
    assert all(getattr(again, name) == getattr(first, name) for name in names)
    shutil.copy(path, tmp_path / "copy.mp4")
    probe(tmp_path / "copy.mp4")  # the same content
    assert len(decoded) == 1


def test_another_file_under_the_same_name(tmp_path: Path, decoded: list[Path]):
    path = film(tmp_path / "a.mp4", 20)
    old = probe(path)
    status = path.stat()
    other = film(tmp_path / "b.mp4", 30).read_bytes()
    path.write_bytes(other)
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert probe(path).sha256 != old.sha256
    assert probe(path).duration_s == 3
    assert len(decoded) == 2


def test_a_large_files_digest_is_kept_by_what_the_disk_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = tmp_path / "a.mp4"
    path.write_bytes(bytes(probing._BLOCK + 1))
    later = time.time_ns() + 10**10
    monkeypatch.setattr(time, "time_ns", lambda: later)
    digest = file_digest(path)
    opened: list[Path] = []
    open_file = Path.open

    def noted(file: Path, *how: Any, **more: Any) -> Any:
        opened.append(file)
        return open_file(file, *how, **more)

    monkeypatch.setattr(Path, "open", noted)
    assert file_digest(path) == digest
    assert path not in opened


def test_damaged_entries_of_the_cache_are_made_again(
    tmp_path: Path, cache: Path, decoded: list[Path]
):
    path = film(tmp_path / "a.mp4", 20)
    info = probe(path)
    (entry,) = (file for file in cache.iterdir() if file.is_file())
    content = entry.read_bytes()
    damaged = [content[:40], b"", content[:-1], content[:50] + b"\0" + content[51:]]
    for count, found in enumerate(damaged, start=2):
        entry.write_bytes(found)
        probing._RECENT.clear()
        assert probe(path).duration_s == info.duration_s
        assert len(decoded) == count
        assert entry.read_bytes() == content


def test_without_a_cache_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, decoded: list[Path]
):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    path = film(tmp_path / "a.mp4", 4)
    assert probe(path).duration_s == probe(path).duration_s == 0.4
    assert len(decoded) == 1


@pytest.mark.parametrize(
    ("name", "frames", "duration_s", "first_s", "size"),
    [
        ("01-webm-no-duration/recorded.webm", 100, 4, 0, (128, 96)),
        ("03-vfr-part/dim-light.mp4", 180, 9.94, 0, (320, 240)),
        ("12-rotated/clips/phone.mp4", 100, 4, 0, (96, 128)),
        ("14-start-offset/late.mp4", 100, 4, 1.5, (320, 240)),
        ("18-replaced-file/push-new.mp4", 25, 1, 0, (128, 96)),
    ],
)
def test_files_of_others(
    name: str, frames: int, duration_s: float, first_s: float, size: tuple[int, int]
):
    info = probe(case(name))
    assert len(info.frame_times) == frames
    assert info.duration_s == pytest.approx(duration_s)
    assert info.first_time_s == first_s
    assert (info.width, info.height) == size
    assert info.is_playable
    assert not info.problem


def test_half_a_file_of_others():
    info = probe(case("15-cut-off-faststart/half.mp4"))
    assert "cut off" in info.problem
    assert info.duration_s == pytest.approx(9.56)
