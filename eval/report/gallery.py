"""Examples to look at: rendered videos with a command and what its clauses are grounded in."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from corpus_tools.corpus.corpus_model import Corpus
from eval.report.plan_results import JudgedPlan, Plans
from g3.annotation import Annotation
from g3.errors import FormatError
from g3.groundings import PhysicalObject
from g3.sdc.clauses import all_words, breadth_first

COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Okabe and Ito (2008): distinct for colour-blind readers."""


@dataclass(frozen=True, slots=True)
class Phrase:
    """A clause and what it is grounded in."""

    text: str
    objects: tuple[str, ...]
    colour: str


@dataclass(frozen=True, slots=True)
class Shown:
    """A video with a command.

    Parameters
    ----------
    name, title
        Of the scenario.
    command
        What somebody has typed or written for it.
    phrases
        Its OBJECTs.
    video, poster
        As data URIs.
    size
        Of the picture, pixels.
    outlines
        Of grounded objects in the poster: a colour, and corners in pixels as SVG has them.
    """

    name: str
    title: str
    command: str
    phrases: tuple[Phrase, ...]
    video: str
    poster: str
    size: tuple[int, int]
    outlines: tuple[tuple[str, str], ...]


def examples(corpus: Corpus, videos: Path, most: int) -> list[Shown]:
    """The first videos of a folder that show contexts of the corpus.

    Parameters
    ----------
    videos
        What ``ct render-videos`` has filled.

    Raises
    ------
    FormatError
        If it has no video of the corpus.
    """
    first: dict[str, Annotation] = {}
    for annotation in corpus.annotations:
        if annotation.source == "positive":
            first.setdefault(annotation.context.id, annotation)
    manifests = sorted(videos.glob("*/manifest.json"))
    known = [(path, json.loads(path.read_bytes())) for path in manifests]
    shown = [(path.parent, m) for path, m in known if m.get("id") in first]
    if not shown:
        raise FormatError(
            "there is no video of the corpus",
            where=str(videos),
            fix="make some with `ct render-videos --out FOLDER`",
        )
    return [_shown(folder, m, first[m["id"]]) for folder, m in shown[:most]]


@dataclass(frozen=True, slots=True)
class Failed:
    """A plan that is wrong, as people would see it.

    Parameters
    ----------
    plan
        With why it is wrong.
    video, poster
        As data URIs.
    """

    plan: JudgedPlan
    video: str
    poster: str


def failures(plans: Plans, most: int) -> list[Failed]:
    """The most probable of the wrong plans, as far as their study's videos are here."""
    found: list[Failed] = []
    for plan in plans.wrong():
        folder = Path(plans.study).parent / "videos" / plan.run
        if plan.run and (folder / "video.mp4").exists() and len(found) < most:
            video = _uri(folder / "video.mp4", "video/mp4")
            found.append(Failed(plan, video, _uri(folder / "poster.png", "image/png")))
    return found


def _shown(folder: Path, manifest: dict[str, Any], annotation: Annotation) -> Shown:
    seen = json.loads((folder / "segmentation.json").read_bytes())
    phrases = _phrases(annotation)
    polygons = {thing["id"]: thing["polygons"] for thing in seen["objects"]}
    outlines = [
        (phrase.colour, " ".join(f"{x},{y}" for x, y in polygon))
        for phrase in phrases
        for thing in phrase.objects
        for polygon in polygons.get(thing, ())
    ]
    return Shown(
        manifest["id"],
        manifest.get("title", ""),
        annotation.command.text,
        tuple(phrases),
        _uri(folder / "video.mp4", "video/mp4"),
        _uri(folder / "poster.png", "image/png"),
        (seen["width"], seen["height"]),
        tuple(outlines),
    )


def _phrases(annotation: Annotation) -> Sequence[Phrase]:
    found: list[Phrase] = []
    nodes = zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True)
    for sdc, groundings in nodes:
        objects = tuple(g.id for g in groundings if isinstance(g, PhysicalObject))
        if sdc.type == "OBJECT" and objects and annotation.context.agent_id not in objects:
            text = " ".join(span.text for span in all_words(sdc))
            found.append(Phrase(text, objects, COLOURS[len(found) % len(COLOURS)]))
    return found


def _uri(path: Path, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"
