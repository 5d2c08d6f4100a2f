"""The worlds of the random tasks: ``objects.xml``, and where the robot starts.

Positions of pallets and trailers are a corner of the footprint, which lies ahead and to the
left of it. That was checked against the contexts of the paper's corpus, which are of the same
simulator, to 2 cm. Positions of other things are taken as their middles.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from g3.errors import FormatError
from g3.geometry.plane import rotate
from g3.groundings import Aspect, Context, FloatArray, PhysicalObject, Prism, Trajectory
from g3.short_repr import short_repr

Remark = Callable[..., None]
"""Function that receives an unusual aspect of a world, and its details."""

ROBOT = "-100"
"""Id of the robot, as in the paper's corpus."""
ROBOT_SIZE_M, ROBOT_HEIGHT_M = 1.5, 2.0
"""The paper's contexts have the forklift as a square around its position."""
START_AWAY_M = 10.0
"""Distance of the robot from the middle of everything, in metres, where no log gives its start."""


@dataclass(frozen=True, slots=True)
class _Model:
    """Labels of the things of a number, and their sizes in metres."""

    labels: tuple[str, ...]
    size: tuple[float, float]
    """Along and across the heading."""
    heights: tuple[float, float]
    """Bottom and top."""
    is_measured: bool = False
    """True if the sizes are those of the paper's contexts; else they are assumed."""
    is_corner: bool = False
    """True if the position is the corner behind and to the right, not the middle."""


def _pallet(*words: str, height: float, is_measured: bool = False) -> _Model:
    return _Model((*words, "pallet"), (1.2, 1.0), (0.0, height), is_measured, is_corner=True)


PALLETS: Mapping[str, _Model] = {
    "1": _pallet("bricks", height=0.8),
    "6": _pallet("generator", height=1.2),
    "7": _pallet("generator", "accessories", height=1.03, is_measured=True),
    "19": _pallet("refrigerator", height=1.9),
    "21": _pallet("tire", "assembly", height=0.7, is_measured=True),
    "22": _pallet("tire", height=0.7, is_measured=True),
    "25": _pallet("washing", "machine", height=1.1),
}
"""By the number in ``<label>``; the number in ``<type>`` is wrong for most."""

THINGS: Mapping[str, _Model] = {
    "1": _Model(("semi", "truck"), (6.0, 2.5), (0.0, 3.5)),
    "3": _Model(("flatbed", "truck"), (7.0, 2.4), (0.0, 1.1)),
    "5": _Model(
        ("flatbed", "trailer"), (5.36, 1.91), (0.44, 0.85), is_measured=True, is_corner=True
    ),
    "8": _Model(("operator",), (0.5, 0.5), (0.0, 1.75)),
    "10": _Model(("drum",), (0.6, 0.6), (0.0, 0.9)),
    "11": _Model(("ship", "container"), (6.06, 2.44), (0.0, 2.6)),
    "12": _Model(("sign", "post"), (0.4, 0.4), (0.0, 2.2)),
    "13": _Model(("berm",), (6.0, 2.0), (0.0, 1.0)),
}
"""By the number in ``<type>``."""

UNKNOWN_PALLET = _pallet(height=1.0)
UNKNOWN_THING = _Model(("object",), (1.0, 1.0), (0.0, 1.0))
TRAILER = ("flatbed", "trailer")

_NUMBERS = r"\s*([-+.\deE]+)[\s,]+([-+.\deE]+)[\s,]+([-+.\deE]+)(?:[\s,]+([-+.\deE]+))?\s*"
_NOT_IN_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@short_repr
@dataclass(frozen=True, slots=True)
class Things:
    """Things in a world, and their assumed properties."""

    objects: tuple[PhysicalObject, ...] = ()
    assumed: tuple[tuple[str, Aspect], ...] = ()


def read_things(text: str, remark: Remark) -> Things:
    """Read the content of ``objects.xml``; FormatError if it isn't XML.

    `remark` receives all that is unusual: unknown numbers, things without a position, and so on.
    """
    objects: dict[str, PhysicalObject] = {}
    assumed: list[tuple[str, Aspect]] = []
    for number, item in enumerate(_parsed(text), start=1):
        name = (item.findtext("id") or "").strip()
        if not name:
            name = f"item-{number}"
            remark("an item of objects.xml has no id; it gets one", name)
        elif name in objects or name == ROBOT:
            name = f"{name}-{number}"
            remark("two items of objects.xml have the same id; the second gets another", name)
        at = _values(item, "position", 3)
        if at is None:
            remark("an item of objects.xml has no position, so it is left out", name)
            continue
        model, aspects = _model(item, name, remark)
        yaw = _heading(item)
        if yaw is None:
            remark("an item of objects.xml has no orientation; 0 is assumed", name)
            aspects.append("heading")
        objects[name] = _thing(name, model, at, yaw or 0.0)
        assumed += [(name, aspect) for aspect in aspects]
    return Things(tuple(objects.values()), tuple(assumed))


def place_robot(
    name: str, things: Things, start: tuple[float, float] | None, remark: Remark
) -> Context:
    """Put the robot into a world. Its heading is 0 and marked as assumed.

    `name` is the context's id, `start` where the log puts the robot, in m; None if it doesn't say.
    """
    assumed: list[tuple[str, Aspect]] = [*things.assumed, (ROBOT, "heading")]
    if start is None:
        middles = [item.prism.xy.mean(axis=0) for item in things.objects] or [np.zeros(2)]
        x, y = np.mean(middles, axis=0)
        start = (float(x) - START_AWAY_M, float(y))
        assumed.append((ROBOT, "position"))
        remark(
            "the log doesn't tell where the robot starts; "
            f"{START_AWAY_M:g} m from the middle of all things is assumed"
        )
    half = ROBOT_SIZE_M / 2
    corners = np.array([[-half, -half], [half, -half], [half, half], [-half, half]]) + start
    robot = PhysicalObject(
        ROBOT,
        ("forklift",),
        Prism(corners, 0.0, ROBOT_HEIGHT_M),
        Trajectory(np.zeros(1), np.array([[*start, 0.0]]), np.zeros(1)),
    )
    return Context(name, (*things.objects, robot), (), ROBOT, tuple(assumed))


def _parsed(text: str) -> ElementTree.Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise FormatError("the file declares entities", fix="remove the declarations")
    body = re.sub(r"^\s*<\?xml.*?\?>", "", _NOT_IN_XML.sub(" ", text), count=1, flags=re.DOTALL)
    try:
        return ElementTree.fromstring(body)  # noqa: S314 - without entities it can't grow
    except ElementTree.ParseError as error:
        raise FormatError(f"the file is not XML: {error}", fix="fetch the file again") from error


def _model(item: ElementTree.Element, name: str, remark: Remark) -> tuple[_Model, list[Aspect]]:
    """Return the kind of a thing, and which of its properties are assumed."""
    kind = item.get("type")
    is_pallet = kind == "pallet"
    if kind not in ("pallet", "object"):
        remark(f"an item of objects.xml is neither pallet nor object but {kind!r}", name)
    number = (item.findtext("label" if is_pallet else "type") or "").strip()
    model = (PALLETS if is_pallet else THINGS).get(number) if kind in ("pallet", "object") else None
    if model is None:
        what = "label of a pallet" if is_pallet else "type of an object"
        remark(f"unknown {what}: {number or 'none'}", name)
        return (UNKNOWN_PALLET if is_pallet else UNKNOWN_THING), ["labels", "size"]
    return model, ([] if model.is_measured else ["size"])


def _thing(name: str, model: _Model, at: FloatArray, yaw: float) -> PhysicalObject:
    length, width = model.size
    x, y = (0.0, 0.0) if model.is_corner else (-length / 2, -width / 2)
    corners = np.array([[x, y], [x, y + width], [x + length, y + width], [x + length, y]])
    # As in the paper's contexts, the second edge of a footprint points where the thing heads.
    footprint = rotate(corners, np.full(4, yaw)) + at[:2]
    # Only pallets stand on something; of other things the height is that of the yard's ground.
    base = float(at[2]) if "pallet" in model.labels else 0.0
    bottom, top = (base + height for height in model.heights)
    pose = np.array([[*footprint.mean(axis=0), (bottom + top) / 2]])
    prism = Prism(footprint, bottom, top)
    return PhysicalObject(name, model.labels, prism, Trajectory(np.zeros(1), pose, np.array([yaw])))


def _values(item: ElementTree.Element, tag: str, count: int) -> FloatArray | None:
    for found in item.findall(tag):
        match = re.fullmatch(_NUMBERS, found.text or "")
        if found.get("id") == "local-frame" and match:
            try:
                values = np.array([float(part) for part in match.groups() if part])
            except ValueError:
                continue
            if len(values) == count and np.isfinite(values).all():
                return values
    return None


def _heading(item: ElementTree.Element) -> float | None:
    """Return the heading of a quaternion w, x, y, z."""
    quaternion = _values(item, "orientation", 4)
    if quaternion is None or not np.linalg.norm(quaternion) > 0:
        return None
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
