"""Everything that a report shows, measured in one go."""

from __future__ import annotations

import base64
import json
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from corpus_tools import __version__
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.judging.judge_validity import Validity, known_validity
from eval.report.plan_results import Bin, JudgedPlan, Plans, bins, read_all_plans
from eval.statistics.estimates import FEWEST_BESIDE
from eval.statistics.ratings import of_study
from eval.table_1 import held_out_predictions
from eval.table_1.correspondence import Row, table_rows
from eval.table_1.divided_examples import Choices
from eval.table_1.error_lists import ErrorList, error_lists
from eval.table_1.learning_curve import CurvePoint
from eval.table_2.rating_shares import Results, table_2
from g3.annotation import Annotation
from g3.errors import FormatError
from g3.features.feature_registry import CATALOGUE_VERSION
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
    manifests_read = [(path, json.loads(path.read_bytes())) for path in manifests]
    shown = [(path.parent, m) for path, m in manifests_read if m.get("id") in first]
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
    result: list[Failed] = []
    for plan in plans.wrong():
        folder = Path(plans.file.study).parent / "videos" / plan.run
        if plan.run and (folder / "video.mp4").exists() and len(result) < most:
            video = _uri(folder / "video.mp4", "video/mp4")
            result.append(Failed(plan, video, _uri(folder / "poster.png", "image/png")))
    return result


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
    result: list[tuple[Phrase, tuple[Span, ...]]] = []
    colours: dict[tuple[str, ...], str] = {}
    nodes = zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True)
    for sdc, groundings in nodes:
        objects = tuple(g.id for g in groundings if isinstance(g, PhysicalObject))
        if sdc.type == "OBJECT" and objects and annotation.context.agent_id not in objects:
            spans = all_words(sdc)
            colour = colours.setdefault(objects, COLOURS[len(colours) % len(COLOURS)])
            result.append((Phrase(" ".join(span.text for span in spans), objects, colour), spans))
    return result


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


STUDY_DRAWS = 10_000
EXAMPLES = 4
LIBRARIES = ("matplotlib", "numpy", "scipy")


@dataclass(frozen=True, slots=True)
class ReportChoices:
    """Inputs and settings of a report."""

    corpus: str
    """The corpus, measured with each scenario held out in turn."""
    plans: Sequence[Path] = ()
    """Files of ``ct eval table3 --format json``, one for each tested corpus."""
    videos: Path | None = None
    """Folder of ``ct render-videos`` for the corpus; None to show none."""
    study: str = ""
    """Name of the rating study for Table 2; the largest if empty."""
    negatives: str = "random"
    l2: float | None = None
    threshold: float = 0.5
    seed: int = 0
    draws: int = 2000
    top: int = 5
    """Phrases in each list of errors."""
    repeats: int = 5
    """Random orders of the commands for the learning curve; 0 for none."""


@dataclass(frozen=True, slots=True)
class Contents:
    """Contents of a report; results that weren't measured are None or empty."""

    table_1: Sequence[Row]
    metadata: dict[str, object]
    """Rows of Table 1, and their metadata."""
    reliability: Sequence[Bin]
    curve: Sequence[CurvePoint]
    repeats: int
    """The learning curve's points, and the number of random orders behind them."""
    errors: Sequence[ErrorList]
    """The lists of section 4.2."""
    is_authored: bool
    """True if nobody typed the commands for a video; the paper's figures aren't beside then."""
    table_2: Results | None
    validity: Validity | None
    plans: Sequence[Plans]
    shown: Sequence[Shown]
    failures: Sequence[Failed]
    """Ratings by people, the judge against them, Table 3 of each tested corpus with new worlds
    first, example videos, and wrong plans'."""
    provenance: dict[str, object]
    """Corpora, settings and versions behind the report."""
    commands: Sequence[str]
    """Commands that reproduce the figures."""


def gather(choices: ReportChoices, on_progress: OnProgress = no_progress) -> Contents:
    """Measure a report's contents; a CorpusError if corpus, plans or videos can't be used."""
    corpus = open_corpus(choices.corpus)
    plans = read_all_plans(choices.plans, corpus.hash)
    shown = examples(corpus, choices.videos, EXAMPLES) if choices.videos else []
    table_choices = Choices(
        corpus=choices.corpus,
        division="cv",
        negatives="hard" if choices.negatives == "hard" else "random",
        l2=choices.l2,
        threshold=choices.threshold,
        seed=choices.seed,
    )
    result = held_out_predictions.run(table_choices, on_progress)
    draws = {"seed": choices.seed, "draws": choices.draws}
    repeats = choices.repeats
    curve = (
        held_out_predictions.learning_curve(table_choices, repeats, on_progress)[0]
        if repeats
        else ()
    )
    ratings: dict[str, Any] = {"seed": choices.seed, "draws": STUDY_DRAWS, "study": choices.study}
    # Of a handful of judgments nothing is shown.
    has_ratings = len(of_study(corpus.judgments, choices.study)) >= FEWEST_BESIDE
    return Contents(
        table_rows(
            result.predictions,
            threshold=choices.threshold,
            seed=choices.seed,
            draws=choices.draws,
        ),
        {"table": 1, **result.metadata, "draws": choices.draws},
        bins(result.predictions, **draws),
        curve,
        repeats,
        error_lists(result.predictions, result.shown, k=choices.top, threshold=choices.threshold),
        corpus.is_authored,
        table_2(corpus.judgments, **ratings) if has_ratings else None,
        known_validity([corpus], **draws) if has_ratings else None,
        plans,
        shown,
        [one for table in plans for one in failures(table, EXAMPLES)][:EXAMPLES],
        {
            "corpus": corpus.name,
            "corpus_hash": corpus.hash,
            "source": corpus.source,
            "licence": corpus.licence,
            "models": "trained in this run, one for each scenario held out",
            "features": CATALOGUE_VERSION,
            "program": f"corpus-tools-g3 {__version__}",
            "python": platform.python_version(),
            "libraries": {name: version(name) for name in LIBRARIES},
            "seed": choices.seed,
            "draws": choices.draws,
            **{f"table_3, {table.name}": table.provenance for table in plans},
        },
        _commands(choices, has_ratings=has_ratings),
    )


def _commands(choices: ReportChoices, *, has_ratings: bool) -> list[str]:
    name, seed = choices.corpus, choices.seed
    common = f"--corpus {name} --seed {seed}"
    result = [
        f"ct eval table1 {common} --cv scenario --negatives {choices.negatives}",
        f"ct eval errors {common} --cv scenario --top {choices.top}",
    ]
    if choices.repeats:
        repeats = f"--repeats {choices.repeats}"
        result.append(f"ct eval learning-curve {common} --cv scenario {repeats} --out curve.svg")
    if has_ratings:
        result += [f"ct eval table2 {common}", f"ct eval judge-validity {common}"]
    whole = [f"ct eval report report --corpus {name} --seed {seed}"]
    for file in choices.plans:
        result.append(
            f"ct eval table3 --train CORPUS --test CORPUS --format json --out {file.name}"
        )
        whole.append(f"--plans {file.name}")
    if choices.videos:
        result.append(f"ct render-videos --corpus {name} --out {choices.videos.name}")
        whole.append(f"--videos {choices.videos.name}")
    return [*result, " ".join(whole)]
