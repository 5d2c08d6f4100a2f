"""The world in which a command is tried, as the page shows it: a picture with marks, and a map.

A scene is a folder with ``scene.json``, as :class:`Scene` has it, and ``picture.png``.
"""

from __future__ import annotations

import functools
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from g3.geometry.plane import rotate
from g3.groundings import FloatArray, Place
from g3.storage.atomic_file import write_bytes

if TYPE_CHECKING:
    from corpus_tools.video.drawing.camera import Camera
    from corpus_tools.world.state.recording import Recording
    from g3.actions.robot_state import State

log = logging.getLogger(__name__)

SCENE, PICTURE = "scene.json", "picture.png"
SIZE = (800, 600)

Corners = list[tuple[float, float]]


class Area(msgspec.Struct, frozen=True):
    """A place: its corners in the picture, if they are in it, and on the map."""

    name: str
    outline: Corners
    footprint: Corners

    @classmethod
    def of(cls, place: Place, start: State, camera: Camera | None) -> Area:
        """Return a place of a world as its scene shows it."""
        outline: Any = []
        if camera is not None:
            corners = np.column_stack(
                (place.prism.xy, np.full(len(place.prism.xy), place.prism.z_min))
            )
            pixels, ahead = camera.project(corners, SIZE)
            outline = [] if (ahead <= 0).any() else np.round(pixels, 1).tolist()
        return cls(place.name, outline, on_map(place.prism.xy, start))


class Thing(msgspec.Struct, frozen=True):
    """A thing: the corners of its visible parts in the picture, and its footprint on the map."""

    id: str
    name: str
    is_robot: bool
    outlines: list[Corners]
    footprint: Corners


class Scene(msgspec.Struct, frozen=True):
    """A world at its start. Maps are in metres, with the robot's heading upwards (y).

    Without a picture, where nothing can be rendered, width and height are 0.
    """

    width: int
    height: int
    things: list[Thing]
    places: list[Area]


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """A rendered picture of a world's start."""

    picture: Any
    """Colours, shape (height, width, 3)."""
    objects: Any
    """Index of the object that each pixel shows, -1 for none."""
    camera: Camera


def scenarios() -> dict[str, Path]:
    """Return the files of the scenarios that can be chosen, by name."""
    from corpus_tools.world.scenarios.scenario_reading import (  # noqa: PLC0415 - needed by few pages
        dataset_folder,
        scenario_files,
    )

    return dict(scenario_files(dataset_folder("warehouse")))


@functools.lru_cache(maxsize=100)
def scenario_state(scenario: str) -> State:
    """Return a scenario's start."""
    from corpus_tools.following.start_states import scenario_start  # noqa: PLC0415 - as above

    return scenario_start(scenarios()[scenario])


def read_scene(folder: Path) -> Scene | None:
    """Return a scene; None if there is none."""
    try:
        return msgspec.json.decode((folder / SCENE).read_bytes(), type=Scene)
    except FileNotFoundError:
        return None


def write_scene(folder: Path, scenario: str) -> None:
    """Write a scenario's scene, with its picture if pictures can be rendered."""
    import cv2  # noqa: PLC0415 - as above

    look = look_of(scenario)
    folder.mkdir(parents=True, exist_ok=True)
    if look is not None:
        _, content = cv2.imencode(".png", look.picture[..., ::-1])
        write_bytes(folder / PICTURE, content.tobytes())
    write_bytes(folder / SCENE, msgspec.json.encode(scene_of(scenario_state(scenario), look)))


def scene_of(start: State, look: Look | None) -> Scene:
    """Return the scene of a start; without a picture, its map."""
    parts: dict[str, list[Corners]] = {}
    if look is not None:
        from corpus_tools.video.drawing.segmentation import describe  # noqa: PLC0415 - as above

        outlines = describe(look.objects, start.context, look.camera)["objects"]
        parts = {outline["id"]: outline["polygons"] for outline in outlines}
    return Scene(
        *(SIZE if look else (0, 0)),
        [
            Thing(
                thing.id,
                " ".join(thing.labels) or thing.id,
                thing.id == start.context.agent_id,
                parts.get(thing.id, []),
                on_map(thing.prism.xy, start),
            )
            # What is low comes first, so that loads stand on what carries them.
            for thing in sorted(start.context.objects, key=lambda o: (o.prism.z_min, o.id))
        ],
        [
            Area.of(place, start, look.camera if look else None)
            for place in start.context.places
            if place.name
        ],
    )


def look_of(scenario: str) -> Look | None:
    """Render a scenario's start; None where nothing can be rendered."""
    try:
        return _look(scenario_state(scenario))
    except Exception:  # drivers fail in many ways
        log.warning("no picture of %s", scenario, exc_info=True)
        return None


def _look(start: State) -> Look:
    from corpus_tools.video.drawing.gl import choose_back_end  # noqa: PLC0415 - before MuJoCo

    choose_back_end()
    from corpus_tools.video.films import open_frames  # noqa: PLC0415 - as above
    from corpus_tools.video.manifest import Settings  # noqa: PLC0415
    from corpus_tools.world.physics.build import build_world  # noqa: PLC0415

    how = Settings(size=SIZE, quality="standard")
    still = _still(start)
    world = build_world(still.start, site=start.site)
    with open_frames(world, still, how.camera, how.size, how.quality) as frames:
        return Look(frames.frame(0), frames.objects.copy(), frames.cameras[0])


def camera_of(start: State) -> Camera:
    """Return the camera of a start's picture, without the picture."""
    from corpus_tools.video.drawing.camera import CAMERAS  # noqa: PLC0415 - as above
    from corpus_tools.video.manifest import Settings  # noqa: PLC0415

    return CAMERAS[Settings().camera](_still(start), SIZE)[0]


def _still(start: State) -> Recording:
    from corpus_tools.world.state.recording import Recording  # noqa: PLC0415 - as above

    context = start.context
    things = context.objects
    yaw = np.array([thing.trajectory.yaw[0] for thing in things])
    none = np.zeros_like(yaw)
    return Recording(
        context,
        np.zeros(1, dtype=np.int64),
        np.array([[thing.trajectory.xyz[0] for thing in things]]),
        np.stack((np.cos(yaw / 2), none, none, np.sin(yaw / 2)), axis=-1)[None],
        np.array([start.forks_m]),
    )


def on_map(xy: FloatArray, start: State) -> Corners:
    """Return points seen from the robot's start, its heading upwards."""
    at = start.context.agent.trajectory
    turned = rotate(xy - at.xyz[0, :2], np.array(np.pi / 2 - at.yaw[0]))
    corners: Corners = np.round(turned, 2).tolist()
    return corners
