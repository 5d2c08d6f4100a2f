"""Example videos for a report, with a command and its clauses' groundings."""

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
from g3.sdc.clauses import Span, all_words, breadth_first

COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Okabe and Ito (2008): distinct for colour-blind readers."""


@dataclass(frozen=True, slots=True)
class Phrase:
    """A clause and its groundings."""

    text: str
    objects: tuple[str, ...]
    colour: str


@dataclass(frozen=True, slots=True)
class Words:
    """A piece of a command, and its innermost clause's colour; empty if it has none."""

    text: str
    colour: str


@dataclass(frozen=True, slots=True)
class Shown:
    """A video with a command."""

    name: str
    title: str
    command: str
    """The command's text, typed or written for the video."""
    words: tuple[Words, ...]
    """The command in pieces: grounded clauses, and the words between."""
    phrases: tuple[Phrase, ...]
    video: str
    poster: str
    """Data URIs of video and poster."""
    size: tuple[int, int]
    """Size of the picture, in pixels."""
    outlines: tuple[tuple[str, str], ...]
    """Grounded objects in the poster: a colour, and corners in pixels, in SVG's form."""


def examples(corpus: Corpus, videos: Path, most: int) -> list[Shown]:
    """Return the first videos that show contexts of the corpus; a FormatError if none does."""
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
    """A plan that is wrong, as people would see it; video and poster are data URIs."""

    plan: JudgedPlan
    video: str
    poster: str


def failures(plans: Plans, most: int) -> list[Failed]:
    """Return the most probable of the wrong plans, with videos of their study here."""
    found: list[Failed] = []
    for plan in plans.wrong():
        folder = Path(plans.file.study).parent / "videos" / plan.run
        if plan.run and (folder / "video.mp4").exists() and len(found) < most:
            video = _uri(folder / "video.mp4", "video/mp4")
            found.append(Failed(plan, video, _uri(folder / "poster.png", "image/png")))
    return found


def _shown(folder: Path, manifest: dict[str, Any], annotation: Annotation) -> Shown:
    seen = json.loads((folder / "segmentation.json").read_bytes())
    clauses = _clauses(annotation)
    phrases = [phrase for phrase, _ in clauses]
    polygons = {thing["id"]: thing["polygons"] for thing in seen["objects"]}
    outlines = [
        (phrase.colour, " ".join(f"{x},{y}" for x, y in polygon))
        for phrase in {phrase.objects: phrase for phrase in phrases}.values()
        for thing in phrase.objects
        for polygon in polygons.get(thing, ())
    ]
    return Shown(
        manifest["id"],
        manifest.get("title", ""),
        annotation.command.text,
        tuple(_words(annotation.command.text, clauses)),
        tuple(phrases),
        _uri(folder / "video.mp4", "video/mp4"),
        _uri(folder / "poster.png", "image/png"),
        (seen["width"], seen["height"]),
        tuple(outlines),
    )


def _clauses(annotation: Annotation) -> list[tuple[Phrase, tuple[Span, ...]]]:
    """Return the OBJECTs but the robot, outer ones first; same groundings share a colour."""
    found: list[tuple[Phrase, tuple[Span, ...]]] = []
    colours: dict[tuple[str, ...], str] = {}
    nodes = zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True)
    for sdc, groundings in nodes:
        objects = tuple(g.id for g in groundings if isinstance(g, PhysicalObject))
        if sdc.type == "OBJECT" and objects and annotation.context.agent_id not in objects:
            spans = all_words(sdc)
            colour = colours.setdefault(objects, COLOURS[len(colours) % len(COLOURS)])
            found.append((Phrase(" ".join(span.text for span in spans), objects, colour), spans))
    return found


def _words(command: str, clauses: Sequence[tuple[Phrase, tuple[Span, ...]]]) -> list[Words]:
    # Inner clauses come last, so that a word has the colour of its innermost one.
    colours = {span: phrase.colour for phrase, spans in clauses for span in spans}
    pieces: list[Words] = []
    end = 0
    for span in sorted(colours):
        between, colour = command[end : span.start], colours[span]
        if pieces and pieces[-1].colour == colour and not between.strip():
            between = pieces.pop().text + between
        elif between:
            pieces.append(Words(between, ""))
            between = ""
        pieces.append(Words(f"{between}{span.text}", colour))
        end = span.end
    return [*pieces, Words(command[end:], "")]


def _uri(path: Path, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"
