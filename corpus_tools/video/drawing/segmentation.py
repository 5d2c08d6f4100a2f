"""Segmentation of a picture: a map of objects by pixel, and their outlines."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import Camera
from g3.groundings import Context

SCHEMA_VERSION = 1
TOLERANCE_PX = 1.0
"""Largest distance of outlines from the pixels' edges, in pixels."""
SMALLEST_PX2 = 4.0
"""Specks smaller than this get no outline."""


def label_image(objects: npt.NDArray[np.int64]) -> npt.NDArray[np.uint16]:
    """Return the map to save: 0 for no object, i + 1 for the i-th, shape (height, width)."""
    return (objects + 1).astype(np.uint16)


def describe(objects: npt.NDArray[np.int64], context: Context, camera: Camera) -> dict[str, Any]:
    """Return the map's description, as it is saved beside it.

    Coordinates are pixels to the right and down from the upper left corner of the picture.
    `objects` has the index of the object that each pixel shows, -1 for none, shape (height, width),
    rows from the top down. `context` has the objects, and the places, whose outlines are where
    nothing hides them.
    """
    height, width = objects.shape
    return {
        "schema_version": SCHEMA_VERSION,
        "width": width,
        "height": height,
        "objects": [
            {"id": item.id, "value": i + 1, "labels": list(item.labels)}
            | _outline((objects == i).astype(np.uint8))
            for i, item in enumerate(context.objects)
        ],
        "places": [
            {
                "index": i,
                "name": place.name,
                "polygon": _on_picture(place.prism.xy, place.prism.z_min, camera, (width, height)),
            }
            for i, place in enumerate(context.places)
        ],
    }


def _outline(mask: npt.NDArray[np.uint8]) -> dict[str, Any]:
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    polygons = [
        cv2.approxPolyDP(contour, TOLERANCE_PX, closed=True)[:, 0].tolist()
        for contour in contours
        if cv2.contourArea(contour) >= SMALLEST_PX2
    ]
    x, y, width, height = cv2.boundingRect(mask)
    pixels = int(np.count_nonzero(mask))
    return {
        "pixels": pixels,
        "box": [x, y, width, height] if pixels else None,
        "polygons": sorted(polygons, key=lambda p: -cv2.contourArea(np.array(p))),
    }


def _on_picture(
    xy: npt.NDArray[np.float64], z: float, camera: Camera, size: tuple[int, int]
) -> list[list[float]] | None:
    """Project a footprint's corners on the picture; None where one is behind the camera."""
    points = np.concatenate((xy, np.full((len(xy), 1), z)), axis=1)
    pixels, ahead = camera.project(points, size)
    return None if (ahead <= 0).any() else np.round(pixels, 2).tolist()
