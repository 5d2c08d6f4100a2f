"""Parts have the frames that people see between two times, and show them as the file does."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from corpus_tools.video.cutting import Span, constant_rate, cut, first_picture, span, whole
from corpus_tools.video.probe import VideoInfo, probe
from g3.errors import FormatError
from tests.shared_cases import case
from tests.small_films import corner, film, numbers

FRAME_S = 0.1


def part_of(file: Path, start_s: float, end_s: float | None = None) -> tuple[Path, VideoInfo, Span]:
    """A part's file, its properties, and its span."""
    info = probe(file)
    part = whole(info) if end_s is None else span(info, start_s, end_s)
    target = file.with_name(f"part-of-{file.stem}.{info.container}")
    cut(file, info, part, target)
    return target, probe(target), part


def assert_plays(info: VideoInfo, duration_s: float) -> None:
    """A part is as long as it should be, from 0 on, for decoders and by its header."""
    assert not info.problem
    assert info.is_playable
    assert info.first_time_s == pytest.approx(0, abs=0.002)
    assert info.duration_s == pytest.approx(duration_s, abs=0.002)
    assert info.stated_s == pytest.approx(duration_s, abs=0.03)


@pytest.mark.parametrize("name", ["a.mp4", "a.webm", "piped.webm", "vp9.webm", "b-frames.mp4"])
@pytest.mark.parametrize(("first", "end"), [(0, 7), (10, 20), (13, 26), (20, 30)])
def test_frames_of_a_part(tmp_path: Path, name: str, first: int, end: int):
    open_gop = {"g": "10", "bf": "3", "x264-params": "open-gop=1"}
    more = {
        "piped.webm": {"is_piped": True},
        "vp9.webm": {"codec": "libvpx-vp9"},
        "b-frames.mp4": {"options": open_gop, "keys": 1000},
    }
    file = film(tmp_path / name, 30, **{"keys": 10, **more.get(name, {})})
    target, info, _ = part_of(file, first / 10, end / 10)
    assert numbers(target) == list(range(first, end))
    assert_plays(info, (end - first) / 10)


def test_what_begins_with_a_key_frame_is_copied(tmp_path: Path):
    file = film(tmp_path / "a.mp4", 30, keys=10)
    with av.open(str(file)) as container:
        packets = {p.pts: bytes(p) for p in container.demux(video=0) if p.pts is not None}
    target = part_of(file, 1, 2)[0]
    assert numbers(target) == list(range(10, 20))
    with av.open(str(target)) as container:
        copied = [bytes(p) for p in container.demux(video=0) if p.pts is not None]
    assert copied == [packets[pts] for pts in sorted(packets)][10:20]


def test_times_of_a_film_with_pauses(tmp_path: Path):
    times = [0, 0.1, 0.2, 1.7, 1.8, 3.0, 3.1]
    file = film(tmp_path / "a.mp4", times, last_s=0.9)
    target, info, part = part_of(file, 0.1, 3.0)
    assert numbers(target) == [1, 2, 3, 4]
    assert_allclose(info.frame_times, [0, 0.1, 1.6, 1.7], atol=0.001)
    assert_plays(info, 2.9)  # the last one stays until the end
    assert constant_rate(probe(file), part) is None
    target, info, _ = part_of(file, 3.0, 4.0)
    assert numbers(target) == [5, 6]
    assert_plays(info, 1.0)


def test_a_part_within_a_pause(tmp_path: Path):
    times = [0, 0.1, 0.2, 2.7, 2.8]
    target, info, part = part_of(film(tmp_path / "a.mp4", times), 1.0, 2.0)
    assert (part.first, part.end, part.duration_s) == (2, 3, 1.0)
    assert numbers(target) == [2]
    assert_plays(info, 1.0)
    target, info, _ = part_of(film(tmp_path / "a.mp4", times), 1.0, 2.8)
    assert numbers(target) == [2, 3]
    assert_allclose(info.frame_times, [0, 1.7], atol=0.001)
    assert_plays(info, 1.8)


@pytest.mark.parametrize("name", ["late.mp4", "late.webm"])
def test_parts_count_from_the_first_frame(tmp_path: Path, name: str):
    file = film(tmp_path / name, [1.5 + n / 10 for n in range(30)])
    target, info, _ = part_of(file, 1, 2)
    assert numbers(target) == list(range(10, 20))
    assert_plays(info, 1)
    target, info, _ = part_of(file, 0)
    assert numbers(target) == list(range(30))
    assert_plays(info, 3)


@pytest.mark.parametrize(
    ("turned", "is_mirrored", "seen"),
    [
        (0, False, "top left"),
        (90, False, "top right"),
        (180, False, "bottom right"),
        (270, False, "bottom left"),
        (0, True, "top right"),
        (90, True, "top left"),
        (180, True, "bottom left"),
        (270, True, "bottom right"),
    ],
)
def test_parts_lie_as_the_file_does(tmp_path: Path, turned: int, is_mirrored: bool, seen: str):
    aspect = Fraction(3, 2)
    file = film(tmp_path / "a.mp4", 12, turned=turned, is_mirrored=is_mirrored, aspect=aspect)
    info = probe(file)
    shown = first_picture(file, info, whole(info))
    assert corner(shown) == seen
    assert shown.shape == (info.height, info.width, 3)
    for start_s, end_s in ((0.3, 0.8), (0, None)):  # encoded, and copied
        target, of_part, _ = part_of(file, start_s, end_s)
        assert (of_part.width, of_part.height) == (info.width, info.height)
        assert corner(first_picture(target, of_part, whole(of_part))) == seen


@pytest.mark.parametrize("name", ["a.mp4", "a.webm"])
@pytest.mark.parametrize("start_s", [1.0, 1.3])
def test_parts_have_the_sound(tmp_path: Path, name: str, start_s: float):
    file = film(tmp_path / name, 30, sound_s=4, keys=10)
    target, info, _ = part_of(file, start_s, 2.5)
    assert info.has_audio
    with av.open(str(target)) as container:
        frames = list(container.decode(audio=0))
    heard = sum(f.samples for f in frames) / frames[0].sample_rate
    assert heard == pytest.approx(2.5 - start_s, abs=0.06)
    assert np.abs(frames[len(frames) // 2].to_ndarray()).max() > 0.1
    assert_plays(info, 2.5 - start_s)


def test_sound_after_the_pictures_is_left_out(tmp_path: Path):
    _, info, _ = part_of(film(tmp_path / "a.mp4", 10, sound_s=3), 0)
    assert_plays(info, 1)


def test_times_between_frames(tmp_path: Path):
    info = probe(film(tmp_path / "a.mp4", 20))
    assert span(info, 0.52, 0.98) == Span(5, 10, 0.5, 1.0)
    assert span(info, 0.58, 1.02) == Span(6, 10, info.frame_times[6], 1.0)
    assert span(info, 0.5, 0.51) == Span(5, 6, 0.5, info.frame_times[6])
    assert span(info, 1.9, 2.0) == Span(19, 20, info.frame_times[19], 2.0)
    assert span(info, 1.9, 2.04) == span(info, 1.9, 2.0)


@pytest.mark.parametrize(("start_s", "end_s"), [(2.0, 3.0), (1.0, 2.2), (5.0, 6.0)])
def test_parts_that_are_not_there(tmp_path: Path, start_s: float, end_s: float):
    info = probe(film(tmp_path / "a.mp4", 20))
    with pytest.raises(FormatError, match="2 s long"):
        span(info, start_s, end_s)


STEPS = st.lists(st.sampled_from([0.02, 0.05, 0.1, 0.4]), min_size=1, max_size=30)


@given(STEPS, st.floats(0, 1), st.floats(0.01, 1))
@settings(max_examples=200)
def test_any_span_is_within_half_a_frame_of_what_was_asked(
    steps: list[float], at: float, share: float
):
    edges = np.concatenate(([0.0], np.cumsum(steps)))
    info = some_info(edges)
    start_s = at * (info.duration_s - 0.01)
    end_s = min(start_s + max(share * (info.duration_s - start_s), 0.001), info.duration_s)
    if start_s >= info.duration_s - np.median(steps) / 2:
        return
    part = span(info, start_s, end_s)
    half = float(np.median(steps)) / 2 + 1e-5
    assert abs(part.start_s - start_s) <= half
    assert 0 <= part.first < part.end <= len(info.frame_times)
    assert part.start_s < part.end_s <= info.duration_s + 1e-9
    assert edges[part.first] <= part.start_s < edges[part.first + 1]
    assert edges[part.end - 1] < part.end_s <= edges[part.end] + 1e-9
    if part.end - part.first > 1:
        assert abs(part.end_s - end_s) <= half


def some_info(edges: np.ndarray) -> VideoInfo:
    return VideoInfo(
        sha256="", frame_times=edges[:-1], first_time_s=0.0, duration_s=float(edges[-1]),
        width=2, height=2, rotation=0, is_mirrored=False, pixel_aspect=Fraction(1),
        container="mp4", codec="h264", pixel_format="yuv420p", fps=10.0, has_audio=False,
        is_playable=True, stated_s=1.0, problem="",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "start_s", "end_s", "frames"),
    [
        ("02-vp8-part/recorded.webm", 1, 3, 50),
        ("03-vfr-part/dim-light.mp4", 5, 9, 40),
        ("12-rotated/clips/phone.mp4", 0.5, 2.5, 50),
        ("14-start-offset/late.mp4", 1, 3, 50),
    ],
)
def test_parts_of_files_of_others(
    tmp_path: Path, name: str, start_s: float, end_s: float, frames: int
):
    file = tmp_path / Path(name).name
    file.write_bytes(case(name).read_bytes())
    before = probe(file)
    _, info, _ = part_of(file, start_s, end_s)
    assert_plays(info, end_s - start_s)
    assert len(info.frame_times) == frames
    assert (info.width, info.height) == (before.width, before.height)
