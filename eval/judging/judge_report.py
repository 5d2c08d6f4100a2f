"""The automatic judge's validity as text and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from rich.table import Table

from eval.judging.judge_validity import JudgedPair, Validity, cohens_kappa, confusion
from eval.statistics.estimates import Estimate
from eval.tables.formats import cell, document, interval, table_text

WANTED_KAPPA = 0.75
CONFIGURATIONS = {"original": True, "random": False}


def render(
    validity: Validity,
    form: Literal["text", "json"],
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """The agreement of the judge with people, and every pair of which they disagree."""
    about = {"judge": "automatic", "compared_with": "people", "study": validity.study, **metadata}
    if form == "json":
        listed = [_listed(pair) for pair in validity.disagreements]
        return document({**summary(validity), "disagreements": listed}, about)
    tables = {
        "Pairs of a command and a video, by what most people and the judge say": _confusion(
            validity
        ),
        "Where they disagree": _disagreements(validity.disagreements),
    }
    return table_text(tables, notes(validity), about, terminal=terminal)


def summary(validity: Validity) -> dict[str, object]:
    """The figures by name, without single pairs."""
    return {
        "kappa": validity.kappa._asdict(),
        "accuracy": validity.accuracy._asdict(),
        "auc": validity.auc._asdict(),
        "kappa_of_other_videos": _kappa(_of(validity, "random")),
        "n": len(validity.pairs),
        "left_out": validity.left_out,
        "configurations": {name: confusion(_of(validity, name)) for name in CONFIGURATIONS},
        "notes": notes(validity),
    }


def notes(validity: Validity) -> list[str]:
    """The figures in words, and what they don't tell."""
    reached = "reaches" if validity.kappa.value >= WANTED_KAPPA else "misses"
    found = [
        f"Cohen's kappa with the majority of people: {_interval(validity.kappa)}; "
        f"it {reached} {WANTED_KAPPA}",
        f"both say the same of {_interval(validity.accuracy)} of the pairs",
        "AUC of people's mean ratings for the judge's yes and no, which has no degrees: "
        f"{_interval(validity.auc)}",
        "95%: percentile intervals with whole videos resampled",
        "a command's own video is right to the judge always, so that kappa speaks for telling own "
        f"videos from others; {_near_misses(validity)}",
    ]
    if validity.left_out:
        found.append(f"{validity.left_out} pairs are left out: a video has no log in the corpus")
    return found


def with_validity(table_3: str, validity: Validity | None) -> str:
    """Table 3 as JSON with the validity of the judge that it is by; null if it isn't known."""
    found = json.loads(table_3)
    return document(found, {"judge_validity": None if validity is None else summary(validity)})


def in_a_line(validity: Validity | None) -> str:
    """What to print beside a figure of the automatic judge."""
    if validity is None:
        return (
            "The automatic judge's validity isn't known: none of the corpora has people's "
            "judgments with the videos' logs."
        )
    return (
        f"The automatic judge against the majority of people: kappa {_interval(validity.kappa)}, "
        f"same verdict {_interval(validity.accuracy)}, {len(validity.pairs)} pairs; "
        f"{_near_misses(validity)}."
    )


def _of(validity: Validity, configuration: str) -> list[JudgedPair]:
    return [p for p in validity.pairs if p.original == CONFIGURATIONS[configuration]]


def _kappa(pairs: Sequence[JudgedPair]) -> float:
    counts = np.array([*confusion(pairs).values()], dtype=float)
    return float(cohens_kappa(counts.reshape(2, 2))) if pairs else float("nan")


def _near_misses(validity: Validity) -> str:
    others = _of(validity, "random")
    fit = [p for p in others if p.people]
    return (
        f"on near misses it is not validated: of {len(others)} pairs with another video {len(fit)} "
        f"fit to people, and the judge agrees on {sum(p.judge for p in fit)} (kappa among them "
        f"{_kappa(others):.2f})"
    )


def _confusion(validity: Validity) -> Table:
    table = Table()
    table.add_column("Video")
    for heading in ("both yes", "people yes", "judge yes", "both no", "n"):
        table.add_column(heading, justify="right")
    for name in CONFIGURATIONS:
        pairs = _of(validity, name)
        counts = confusion(pairs).values()
        table.add_row(name, *(str(n) for n in counts), str(len(pairs)))
    return table


def _disagreements(pairs: Sequence[JudgedPair]) -> Table:
    table = Table()
    for heading in ("People", "Judge", "Ratings", "Own video", "Shown", "Command", "Why"):
        table.add_column(heading)
    for pair in pairs:
        table.add_row(
            "yes" if pair.people else "no",
            "yes" if pair.judge else "no",
            " ".join(map(str, pair.ratings)),
            cell(pair.command_video),
            cell(pair.shown_video),
            cell(pair.command),
            cell(pair.reason),
        )
    return table


def _listed(pair: JudgedPair) -> dict[str, object]:
    return {
        "command": pair.command,
        "command_video": pair.command_video,
        "shown_video": pair.shown_video,
        "ratings": list(pair.ratings),
        "people": pair.people,
        "judge": pair.judge,
        "reason": pair.reason,
    }


def _interval(estimate: Estimate) -> str:
    return f"{estimate.value:.2f} ({interval(estimate.low, estimate.high)})"
