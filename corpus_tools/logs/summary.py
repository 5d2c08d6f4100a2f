"""Summaries of logs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from corpus_tools.logs.log_reading import Log
from corpus_tools.world.state.recording import Step


@dataclass(frozen=True, slots=True)
class ObjectSummary:
    """An object, and the length of its way in metres."""

    id: str
    labels: tuple[str, ...]
    travelled_m: float


@dataclass(frozen=True, slots=True)
class Summary:
    """Summary of a log's content."""

    scenario: str
    duration_s: float
    moments: int
    robot: str
    objects: tuple[ObjectSummary, ...]
    places: tuple[str, ...]
    steps: tuple[Step, ...]
    metadata: Mapping[str, str]


def summary(log: Log) -> Summary:
    """Sum a log up; places without a name are left out."""
    recording = log.recording
    way = np.linalg.norm(np.diff(recording.position, axis=0), axis=2).sum(axis=0).tolist()
    return Summary(
        scenario=log.name,
        duration_s=float(recording.t_s[-1] - recording.t_s[0]),
        moments=len(recording.t_ns),
        robot=recording.start.agent_id,
        objects=tuple(
            ObjectSummary(item.id, item.labels, metres)
            for item, metres in zip(recording.start.objects, way, strict=True)
        ),
        places=tuple(place.name for place in recording.start.places if place.name),
        steps=recording.steps,
        metadata=log.metadata,
    )


def as_table(held: Summary) -> str:
    """Return the summary as a table for people."""
    lines = [
        f"scenario  {held.scenario}",
        f"duration  {held.duration_s:.2f} s, {held.moments} moments",
        f"robot     {held.robot}",
        f"places    {', '.join(held.places) or 'none'}",
        *(f"{name}: {value}" for name, value in held.metadata.items()),
        "",
        f"{len(held.objects)} objects",
        *(
            f"  {item.id}  {' '.join(item.labels)}"
            + (f", travels {item.travelled_m:.2f} m" if item.travelled_m else "")
            for item in held.objects
        ),
        "",
        f"{len(held.steps)} steps",
        *(
            f"  {step.start_s:7.2f} to {step.end_s:7.2f} s  {step.action} "
            + " ".join(value for _, value in step.arguments)
            for step in held.steps
        ),
    ]
    return "\n".join(lines)
