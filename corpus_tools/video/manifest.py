"""The manifest of a rendered folder: its content, its settings, and its files' hashes."""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from corpus_tools import __version__
from corpus_tools.runtime.shipped import program_digest
from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.drawn_moments import clock
from corpus_tools.video.encode import Quality
from corpus_tools.video.items import Story
from corpus_tools.world.state.recording import Recording
from g3.short_repr import short_repr

SCHEMA_VERSION = 1
MANIFEST = "manifest.json"
PROGRAM = "corpus-tools-g3"

_MAKERS = ("video", "world", "logs")
"""Folders with the modules that determine the rendering."""
_LIBRARIES = ("av", "mcap", "mujoco", "numpy", "opencv-python-headless", "scipy")
"""Distributions that determine it too."""


@short_repr
@dataclass(frozen=True, slots=True)
class Settings:
    """Options of videos."""

    camera: str = "track"
    """One of :data:`~corpus_tools.video.drawing.camera.CAMERAS`."""
    size: tuple[int, int] = (1280, 720)
    """Width and height, pixels, both even."""
    fps: int = 25
    quality: Quality = "standard"
    """Quality of drawing and encoding."""
    speed: float = 1.0
    """Seconds of the recording that a second of video shows."""
    skip_idle: bool = False
    """True if long stretches in which nothing moves are cut short."""
    names: bool = False
    """True if the names of places are painted on the ground."""


def input_hash(story: Story, settings: Settings) -> str:
    """Return a digest of all that determines the files: events, settings and program."""
    parts = [story.id, story.title, story.fingerprint, story.site, asdict(settings), _program()]
    return "sha256:" + hashlib.sha256(msgspec.json.encode(parts, order="sorted")).hexdigest()


def manifest(
    story: Story,
    settings: Settings,
    recording: Recording,
    cameras: list[Camera],
    files: Mapping[str, bytes],
) -> bytes:
    """Return the manifest's content, of a recording sampled at the video's frames.

    `files` are the other files of the folder by name.
    """
    first, times = cameras[0], clock(recording, settings.fps)
    video_s, log_s = zip(*times, strict=True)

    def shown_s(seconds: float) -> float:
        return float(np.round(np.interp(seconds, log_s, video_s), 6))

    content: dict[str, Any] = {
        "schema_version": SCHEMA_VERSION,
        "program": {"name": PROGRAM, "version": __version__},
        "id": story.id,
        "title": story.title,
        "input_hash": input_hash(story, settings),
        "settings": asdict(settings),
        "duration_s": len(recording.t_ns) / settings.fps,
        "frames": len(recording.t_ns),
        "fps": settings.fps,
        "clock": times,
        "camera": {
            "name": settings.camera,
            "fixed": len(cameras) == 1,
            "intrinsics": first.intrinsics(settings.size).tolist(),
            "extrinsics": first.extrinsics().tolist(),
        },
        "steps": [
            {
                "action": step.action,
                "arguments": dict(step.arguments),
                "start_s": shown_s(step.start_s),
                "end_s": shown_s(step.end_s),
            }
            for step in recording.steps
        ],
        "files": {
            name: {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
            for name, data in sorted(files.items())
        },
    }
    return msgspec.json.format(msgspec.json.encode(content), indent=2) + b"\n"


def is_finished(folder: Path, wanted_hash: str) -> bool:
    """Check that a folder holds all files made of the same input, unchanged."""
    try:
        content = msgspec.json.decode((folder / MANIFEST).read_bytes())
        return content["input_hash"] == wanted_hash and all(
            hashlib.sha256((folder / name).read_bytes()).hexdigest() == file["sha256"]
            for name, file in content["files"].items()
        )
    except (OSError, msgspec.DecodeError, KeyError, TypeError, AttributeError):
        return False


@functools.cache
def _program() -> str:
    """Return a digest of the program and its libraries."""
    digest = hashlib.sha256(program_digest(*_MAKERS).encode())
    for name in _LIBRARIES:
        try:
            digest.update(f"{name} {importlib.metadata.version(name)}\n".encode())
        except importlib.metadata.PackageNotFoundError:  # another build of the same library
            digest.update(f"{name} ?\n".encode())
    return digest.hexdigest()
