"""The view of a video's world that people get: outlines in the picture and a map, without names.

Ids that people see are made for each item, so that neither they nor their order reveal the
things.
"""

from __future__ import annotations

import functools
import hashlib
import hmac
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.logs.log_reading import read_log
from corpus_tools.world.state.recording import to_context
from g3.errors import FormatError
from g3.geometry.plane import rotate
from g3.groundings import Context, PhysicalObject, Prism, Trajectory
from g3.storage import regular_file

MANIFEST, SEGMENTATION = "manifest.json", "segmentation.json"
MOST_VIEWS = 8
"""Largest number of cameras whose videos people see side by side."""
VIEWS = tuple(f"view-{number}" for number in range(2, MOST_VIEWS + 1))
"""The roles of a video's files by its cameras after the first."""
CURVES = "curves"
"""The role of a file of numbers beside a video."""
TRACK_S = 0.5
"""Time between the poses of moving things that people can see on the map."""
MARGIN_M = 3.0
ID_CHARACTERS = 10
DRAWN = "drawn thing"
"""Label of things that people have drawn where nobody had marked them."""
SAME_S = 1e-6
"""Frames' times are rounded to nanoseconds."""


class Beside(msgspec.Struct, frozen=True):
    """The part of a manifest that describes what people see beside a video, on its clock."""

    cameras: tuple[str, ...] = ()
    """Names of the cameras, that of the video first, if there are several."""
    curves_start_s: float = 0.0
    """Time of the curves at which the video begins."""

    def payload(self, media: Mapping[str, str]) -> dict[str, Any] | None:
        """Return a page's data of it; None if there is nothing.

        It has ``cameras``; ``views``, names of media of all cameras but the first; ``curves``, a
        name of media or None; and ``curves_start_s``.
        """
        views, curves = [media[role] for role in VIEWS if role in media], media.get(CURVES)
        if not views and curves is None:
            return None
        return {
            "cameras": [*map(camera_name, self.cameras)],
            "views": views,
            "curves": curves,
            "curves_start_s": self.curves_start_s,
        }


def camera_name(feature: str) -> str:
    """Return the name of a camera that people see: ``wrist`` of ``observation.images.wrist``."""
    return re.sub(r"^observation\.(images?|depths?)\.", "", feature)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A video's world."""

    context: Context
    """Objects and places, with the trajectories of the video, whose time starts at `start_s`."""
    start_s: float
    """Time of the first frame on the context's clock."""
    duration_s: float
    """Duration of the video."""
    steps: tuple[tuple[float, float], ...]
    """Start and end of each step of the robot's script, in seconds from the first frame."""
    segmentation: Mapping[str, Any]
    """The content of ``segmentation.json``; empty if there is no picture."""
    fps: float | None = None
    """Frames of the video in a second, if that is known."""
    is_picture: bool = False
    """True if only a picture is known, without a world: the context is the picture's plane then,
    with y upwards and a pixel as its unit, and nothing may be exported from it."""
    clock: tuple[tuple[float, float], ...] = ()
    """Seconds of the video, and since its start on the context's clock, where the pace changes;
    empty where both are the same."""
    beside: Beside = field(default_factory=Beside)
    """The signals that people see beside the video."""

    def since_start(self, video_s: float) -> float:
        """Return seconds since the start on the context's clock, for a second of the video."""
        if not self.clock:
            return video_s
        video, happening = zip(*self.clock, strict=True)
        return float(np.interp(video_s, video, happening))

    def video_times(self, t: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the seconds of the video that show times of the context's clock."""
        since = t - self.start_s
        if not self.clock:
            return since
        video, happening = zip(*self.clock, strict=True)
        seen: npt.NDArray[np.float64] = np.interp(since, happening, video)
        return seen


def read_scene(folder: Path, corpus: Path | None = None, context_id: str = "") -> Scene:
    """Read a folder of ``ct render-videos``.

    A replay of an imported corpus has its context there, by its id. A FormatError says what can't
    be read.
    """
    manifest_file = folder / MANIFEST
    stamp = manifest_file.stat().st_mtime_ns if manifest_file.exists() else 0
    return _read(folder, corpus, context_id, stamp)


@dataclass(frozen=True, slots=True)
class Film:
    """The description of a video by its manifest."""

    duration_s: float
    """Duration of the video."""
    has_scene: bool
    """True if there is a world, with the places of its things; false for videos from elsewhere."""
    metadata: Mapping[str, Any]
    """Metadata that the study's owner gives for a video from elsewhere."""
    fps: float | None = None
    """Frames in a second, if that is known."""
    has_things: bool = True
    """True if the places of things are known, if only in a picture."""
    size: tuple[int, int] | None = None
    """Width and height of its pictures, if that is known."""
    beside: Beside = field(default_factory=Beside)
    """The signals that people see beside it."""


def read_film(folder: Path) -> Film:
    """Read a video's manifest; raise FormatError if it can't be read."""
    file = folder / MANIFEST
    return _read_film(file, file.stat().st_mtime_ns if file.exists() else 0)


@functools.lru_cache(maxsize=4096)
def _read_film(file: Path, _stamp: int) -> Film:
    manifest = _json(file)
    has_scene = bool(manifest.get("has_scene", True))
    metadata = manifest.get("metadata", {}) if not has_scene else {}
    has_things = has_scene or "things" in manifest
    duration_s = float(manifest["duration_s"])
    fps, beside = manifest.get("fps"), _beside(manifest)
    size = tuple(manifest["size"]) if "size" in manifest else None
    return Film(duration_s, has_scene, metadata, fps, has_things, size=size, beside=beside)


def _beside(manifest: Mapping[str, Any]) -> Beside:
    return msgspec.convert(manifest.get("beside", {}), Beside)


@functools.lru_cache(maxsize=256)
def _read(folder: Path, corpus: Path | None, context_id: str, _stamp: int) -> Scene:
    manifest = _json(folder / MANIFEST)
    segmentation = _json(folder / SEGMENTATION) if (folder / SEGMENTATION).exists() else {}
    is_picture = not manifest.get("has_scene", True)
    if is_picture:
        context = _plane(segmentation, manifest["id"])
    elif corpus is None:
        context = to_context(read_log(folder / "log.mcap").recording)
    else:
        context = _contexts(corpus)[context_id]
    return Scene(
        context=context,
        start_s=0.0 if is_picture else float(context.agent.trajectory.t[0]),
        duration_s=float(manifest["duration_s"]),
        steps=tuple((float(s["start_s"]), float(s["end_s"])) for s in manifest["steps"]),
        segmentation=segmentation,
        fps=manifest.get("fps"),
        is_picture=is_picture,
        clock=_clock(manifest),
        beside=_beside(manifest),
    )


def with_drawn(scene: Scene, drawn: Iterable[Mapping[str, Any]]) -> Scene:
    """Return a picture's scene with things that people have drawn, once each.

    They have ``id``, ``box`` and ``polygons``, as those of ``segmentation.json``.
    """
    things = {one["id"]: one for one in scene.segmentation.get("objects", [])}
    added = {one["id"]: one for one in drawn if one["id"] not in things}
    if not added:
        return scene
    new = [{**one, "label": DRAWN, "value": 0, "is_drawn": True} for one in added.values()]
    segmentation = {**scene.segmentation, "objects": [*things.values(), *new]}
    return replace(scene, segmentation=segmentation, context=_plane(segmentation, scene.context.id))


def _clock(manifest: Mapping[str, Any]) -> tuple[tuple[float, float], ...]:
    """Return pairs of video and log seconds if ``--speed`` or ``--skip-idle`` make them differ."""
    knots = tuple((float(video), float(log)) for video, log in manifest.get("clock", ()))
    return knots if any(abs(video - log) > SAME_S for video, log in knots) else ()


def _plane(segmentation: Mapping[str, Any], name: str) -> Context:
    """Return the things of a picture in its plane; there is no robot."""
    things = []
    for outline in segmentation.get("objects", []):
        x, y, width, height = outline["box"]
        right, bottom = x + width, y + height
        corners = np.array([(x, -bottom), (right, -bottom), (right, -y), (x, -y)], dtype=np.float64)
        at = Trajectory(np.zeros(1), np.array([[x + width / 2, -bottom, 0.0]]), np.zeros(1))
        things.append(
            PhysicalObject(outline["id"], (outline["label"],), Prism(corners, 0.0, 0.0), at)
        )
    return Context(name, tuple(things), (), agent_id="")


@functools.lru_cache(maxsize=8)
def _contexts(corpus: Path) -> Mapping[str, Context]:
    return Corpus.load(corpus).contexts


def _json(path: Path) -> dict[str, Any]:
    try:
        return msgspec.json.decode(regular_file.read_bytes(path), type=dict[str, Any])
    except (OSError, msgspec.DecodeError) as error:
        raise FormatError(
            f"the file can't be read: {error}",
            where=str(path),
            fix="make the video again with `ct render-videos --force`",
        ) from error


def thing_names(context: Context) -> Mapping[str, str]:
    """Return what the things of a world are called, by their ids.

    That is their labels, numbered where several have the same.
    """
    return dict(zip((o.id for o in context.objects), _numbered(context), strict=True))


def _numbered(context: Context) -> Iterator[str]:
    labels = [" ".join(thing.labels) or "thing" for thing in context.objects]
    seen: Counter[str] = Counter()
    for label in labels:
        seen[label] += 1
        yield f"{label} {seen[label]}" if labels.count(label) > 1 else label


def place_names(context: Context) -> Sequence[str]:
    """Return what the places of a world are called, in their order."""
    return [
        place.name or f"unnamed place {number}"
        for number, place in enumerate(context.places, start=1)
    ]


@dataclass(frozen=True, slots=True)
class Aliases:
    """From what people see in one item to an object's id, or a place's index in its context."""

    objects: Mapping[str, str]
    places: Mapping[str, int]


def aliases(scene: Scene, item_id: str, salt: bytes) -> Aliases:
    """Return the names of a scene's things in an item; they reveal nothing without the salt."""

    def alias(kind: str, name: str) -> str:
        message = f"{item_id}\0{scene.context.id}\0{kind}\0{name}".encode()
        return hmac.new(salt, message, hashlib.sha256).hexdigest()[:ID_CHARACTERS]

    return Aliases(
        {alias("object", item.id): item.id for item in scene.context.objects},
        {alias("place", str(i)): i for i in range(len(scene.context.places))},
    )


def scene_payload(scene: Scene, names: Aliases, media: Mapping[str, str]) -> dict[str, Any]:
    """Return a page's data of a scene.

    It has ``video``, ``poster``: names of media, or None; ``duration_s``; ``fps``, or None;
    ``beside``: see :meth:`Beside.payload`;
    ``steps``: start and end of each; ``segmentation``: ``image`` (a name of media), ``width``,
    ``height`` and ``objects`` with ``id``, ``value``, ``box``, ``polygons`` in pixels of the
    poster, and ``moments`` of the video where more are known (see
    :class:`~annotation_app.study_setup.coco_things.PictureThings`); ``map``: see :func:`_map`.
    """
    public = {real: alias for alias, real in names.objects.items()}
    outlines = [
        {
            "id": public[item["id"]],
            "value": item["value"],
            "box": item["box"],
            "polygons": item["polygons"],
            **{name: item[name] for name in ("moments", "is_drawn") if name in item},
        }
        for item in scene.segmentation.get("objects", [])
        if item["id"] in public
    ]
    return {
        "video": media.get("video"),
        "poster": media.get("poster"),
        "duration_s": scene.duration_s,
        "fps": scene.fps,
        "beside": scene.beside.payload(media),
        "steps": [list(step) for step in scene.steps],
        "segmentation": {
            "image": media.get("segmentation"),
            "width": scene.segmentation.get("width", 0),
            "height": scene.segmentation.get("height", 0),
            "objects": sorted(outlines, key=lambda outline: outline["id"]),
        },
        "map": _map(scene, names),
    }


def film_payload(film: Film, media: Mapping[str, str]) -> dict[str, Any]:
    """Return a page's data of a video whose things are unknown: no outlines, and an empty map."""
    return {
        "video": media.get("video"),
        "poster": media.get("poster"),
        "duration_s": film.duration_s,
        "fps": film.fps,
        "beside": film.beside.payload(media),
        "steps": [],
        "segmentation": {"image": None, "width": 0, "height": 0, "objects": []},
        "map": {"bounds": [0] * 4, "robot": None, "missing": True, "objects": [], "places": []},
    }


def _map(scene: Scene, names: Aliases) -> dict[str, Any]:
    """Return the world from above, in metres.

    It has ``bounds``: least and greatest x and y; ``turn``: by how much people see it turned (see
    :func:`map_turn`); ``robot``: id of the robot, or None; ``missing``: whether only a picture is
    known, so that there is no map to show; ``objects``: ``id``, ``footprint`` (at the first
    moment), ``z`` of the top, and for those that move ``track``, rows of seconds, x, y of a point
    of the thing, and its yaw; ``places``: ``id`` and ``polygon``.
    """
    public = {real: alias for alias, real in names.objects.items()}
    context = scene.context
    corners = np.concatenate(
        [np.zeros((1, 2)) if scene.is_picture else np.empty((0, 2))]
        + [o.prism.xy for o in context.objects]
        + [p.prism.xy for p in context.places]
        + [o.trajectory.xyz[:, :2] for o in context.objects]
    )
    low, high = corners.min(axis=0) - MARGIN_M, corners.max(axis=0) + MARGIN_M
    things = []
    for item in context.objects:
        thing: dict[str, Any] = {
            "id": public[item.id],
            "footprint": _rounded(item.prism.xy),
            "z": round(item.prism.z_max, 2),
        }
        if len(item.trajectory) > 1:
            thing["track"] = _track(item, scene)
        things.append(thing)
    place_names = {index: alias for alias, index in names.places.items()}
    places = [
        {"id": place_names[i], "polygon": _rounded(place.prism.xy)}
        for i, place in enumerate(context.places)
    ]
    return {
        "bounds": _rounded(np.concatenate((low, high))),
        "turn": round(map_turn(scene), 4),
        "robot": public.get(context.agent_id),
        "missing": scene.is_picture,
        "objects": sorted(things, key=lambda thing: str(thing["id"])),
        "places": sorted(places, key=lambda place: str(place["id"])),
    }


def map_turn(scene: Scene) -> float:
    """Return the angle by which the map is turned to lie as the picture does, in radians.

    It is the rotation that best brings where things are on the map to where they stand in the
    picture; 0 if less than two are seen.
    """
    prisms = {item.id: item.prism for item in scene.context.objects}
    seen = [
        (prisms[outline["id"]].xy.mean(axis=0), outline["box"])
        for outline in scene.segmentation.get("objects", [])
        if outline["id"] in prisms and outline["box"] and outline["polygons"]
    ]
    if len(seen) < 2:
        return 0.0
    on_map = np.array([middle for middle, _ in seen])
    on_map -= on_map.mean(axis=0)
    in_picture = np.array([(x + w / 2, -(y + tall)) for _, (x, y, w, tall) in seen])
    in_picture -= in_picture.mean(axis=0)
    cross = on_map[:, 0] @ in_picture[:, 1] - on_map[:, 1] @ in_picture[:, 0]
    return float(np.arctan2(cross, (on_map * in_picture).sum()))


def _track(item: PhysicalObject, scene: Scene) -> Any:
    t = scene.video_times(item.trajectory.t)
    moments = np.arange(0.0, float(t[-1]) + TRACK_S, TRACK_S)
    columns = [
        np.interp(moments, t, values)
        for values in (*item.trajectory.xyz[:, :2].T, item.trajectory.yaw)
    ]
    return _rounded(np.column_stack([moments, *columns]))


def footprint_at(item: PhysicalObject, t: float) -> npt.NDArray[np.float64]:
    """Return an object's footprint at a time of the context's clock, shape (k, 2)."""
    path = item.trajectory
    x, y, yaw = (np.interp(t, path.t, v) for v in (path.xyz[:, 0], path.xyz[:, 1], path.yaw))
    relative = item.prism.xy - path.xyz[0, :2]
    turned = rotate(relative, np.full(len(relative), yaw - path.yaw[0]))
    moved: npt.NDArray[np.float64] = turned + np.array([x, y])
    return moved


def _rounded(values: npt.NDArray[np.float64]) -> Any:
    return np.round(values, 3).tolist()
