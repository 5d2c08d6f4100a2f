"""The automatic judge's validity as text and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Literal

from rich.table import Table

from corpus_tools.corpus.estimate import Estimate, explained
from corpus_tools.runtime.text_tables import figure_table
from eval.judging.judge_validity import ENDS, VERDICTS, WORDS, Agreement, JudgedPair, Validity
from eval.statistics.ratings import judged_by
from eval.tables.formats import (
    cell,
    document,
    figure,
    interval,
    left_out,
    stated,
    table_text,
    value,
)

WANTED_KAPPA = 0.4
"""Landis and Koch (Biometrics 33, 1977) call agreement above this moderate."""
GROUPS = {
    "all": "all",
    "chosen_on": "rules chosen on them",
    "others": "other scenarios",
}
NAMED = ("kappa", "precision", "recall", "accuracy")
"""An agreement's figures."""
COUNTS = ("both yes", "people yes", "judge yes", "both no", "n")
OWN_SAYS_LITTLE = (
    "pairs with a command's own video say little: the judge says yes to these by construction, for "
    "it compares with that video's log, or with what was annotated in it"
)


def render(
    validity: Validity,
    form: Literal["text", "json"],
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """Render the judge's agreement with people, and every pair on which they disagree."""
    about = {
        "judge": "automatic",
        "compared_with": judged_by(validity.study),
        "study": validity.study,
        **metadata,
    }
    if form == "json":
        listed = [asdict(pair) for pair in validity.disagreements]
        return document({**summary(validity), "disagreements": listed}, about)
    near = [p for p in validity.disagreements if not p.original]
    own_videos = [p for p in validity.disagreements if p.original]
    tables = {
        "Near misses: commands with another video than their own": _near_misses(validity),
        "Commands with their own video": _own_videos(validity),
        "Near misses of which a verdict says another thing than most people": _disagreements(
            near, validity
        ),
        "Own videos of which a verdict says another thing than most people": _disagreements(
            own_videos, validity
        ),
    }
    return table_text(tables, notes(validity), about, terminal=terminal)


def summary(validity: Validity) -> dict[str, object]:
    """Return the figures by name, without single pairs."""
    return {
        "near_misses": {
            verdict: {name: _figures(agreement) for name, agreement in groups.items()}
            for verdict, groups in validity.near_misses.items()
        },
        "own_videos": {v: _figures(agreement) for v, agreement in validity.own_videos.items()},
        "all_pairs": {
            ENDS: {**_figures(validity.together), "auc": validity.auc._asdict()},
        },
        "n": len(validity.pairs),
        "left_out": validity.left_out,
        "not_judged_by_words": _unjudged(validity),
        "notes": notes(validity),
    }


def notes(validity: Validity) -> list[str]:
    """State the figures in words, and their limits."""
    lines = [f"{title}: {_near(validity, v)}" for v, title in validity.titles.items()]
    lines += [
        OWN_SAYS_LITTLE,
        f"all pairs together, {VERDICTS[ENDS]}: kappa {stated(validity.together.kappa)}, same "
        f"verdict {stated(validity.together.accuracy)}, AUC of people's mean ratings "
        f"{stated(validity.auc)}",
        "95%: percentile intervals with whole videos resampled; precision: of what the judge calls "
        "right, the part that people accept; recall: of what they accept, the part it calls right",
    ]
    estimates = _estimates(validity)
    lines += explained(estimates.values())
    lines += left_out(estimates, "the")
    if validity.left_out:
        lines.append(f"{validity.left_out} pairs are left out: a video has no log in the corpus")
    if _unjudged(validity):
        lines.append(
            f"{_unjudged(validity)} pairs have no verdict by words: the command isn't annotated, "
            "or states nothing that can be measured"
        )
    return lines


def with_validity(table_3: str, validity: Validity | None) -> str:
    """Table 3 as JSON with the validity of the judge that it is by; null if it isn't known."""
    table = json.loads(table_3)
    return document(table, {"judge_validity": None if validity is None else summary(validity)})


def in_a_line(validity: Validity | None) -> str:
    """Return one line to print beside a figure of the automatic judge."""
    if validity is None:
        return (
            "The automatic judge's validity isn't known: none of the corpora has people's "
            "judgments with the videos' logs."
        )
    verdicts = "; ".join(f"{title}: {_near(validity, v)}" for v, title in validity.titles.items())
    return f"The automatic judge against the majority of people, on near misses: {verdicts}."


def _near(validity: Validity, verdict: str) -> str:
    """State a verdict's agreement on near misses; the second one's on held-out scenarios."""
    groups = validity.near_misses[verdict]
    name = "others" if verdict == WORDS and groups["others"].n else "all"
    agreement = groups[name]
    if not agreement.n:
        return "no pair with another video"
    where = " of scenarios that its rules weren't chosen on" if name == "others" else ""
    reached = "reaches" if agreement.kappa.value >= WANTED_KAPPA else "misses"
    compared = f", which {reached} {WANTED_KAPPA}" if agreement.kappa.is_known else ""
    both, yes = agreement.counts["people_yes_judge_yes"], agreement.counts["people_yes_judge_no"]
    return (
        f"kappa {stated(agreement.kappa)}{compared}, on {agreement.n} near misses"
        f"{where}; people accept {both + yes}, and the verdict {both} of these and "
        f"{agreement.counts['people_no_judge_yes']} others"
    )


def _estimates(validity: Validity) -> dict[str, Estimate]:
    """Return all figures, by description."""
    agreements = {
        f"{title}, {GROUPS[name]} near misses": agreement
        for verdict, title in validity.titles.items()
        for name, agreement in validity.near_misses[verdict].items()
    }
    agreements[f"all pairs, {VERDICTS[ENDS]}"] = validity.together
    figures = {
        f"{name} of {of}": getattr(agreement, name)
        for of, agreement in agreements.items()
        for name in NAMED
    }
    return {**figures, "AUC": validity.auc}


def _unjudged(validity: Validity) -> int:
    return sum(WORDS not in p.verdicts for p in validity.pairs)


def _figures(agreement: Agreement) -> dict[str, object]:
    figures = {name: getattr(agreement, name)._asdict() for name in NAMED}
    return {**figures, "counts": agreement.counts, "n": agreement.n}


def _near_misses(validity: Validity) -> Table:
    first = ("Verdict", "Scenarios", "kappa", "95%", "precision", "recall")
    table = figure_table((*first, *COUNTS), words=len(first))
    for verdict, groups in validity.near_misses.items():
        for name, agreement in groups.items():
            kappa = agreement.kappa
            shown = (
                figure(kappa.value),
                interval(kappa),
                *map(value, (agreement.precision, agreement.recall)),
            )
            table.add_row(validity.titles[verdict], GROUPS[name], *shown, *_counts(agreement))
    return table


def _own_videos(validity: Validity) -> Table:
    rows = (
        (validity.titles[v], *_counts(agreement)) for v, agreement in validity.own_videos.items()
    )
    return figure_table(("Verdict", *COUNTS), rows)


def _counts(agreement: Agreement) -> list[str]:
    return [*map(str, agreement.counts.values()), str(agreement.n)]


def _disagreements(pairs: Sequence[JudgedPair], validity: Validity) -> Table:
    others = [verdict for verdict in validity.titles if verdict not in VERDICTS]
    last = ("Ratings", "Own video", "Shown", "Command", "Why not")
    table = Table("People", "By log", "By words", *others, *last)
    for pair in pairs:
        table.add_row(
            _yes(pair.people),
            *(
                _yes(pair.verdicts[v].correct) if v in pair.verdicts else "-"
                for v in validity.titles
            ),
            " ".join(map(str, pair.ratings)),
            cell(pair.command_video),
            cell(pair.shown_video),
            cell(pair.command),
            cell("; ".join(_reasons(pair))),
        )
    return table


def _reasons(pair: JudgedPair) -> list[str]:
    short = {ENDS: "by log", WORDS: "by words"}
    return [
        f"{short.get(v, v)}: {verdict.reason}"
        for v, verdict in pair.verdicts.items()
        if verdict.reason
    ]


def _yes(fits: bool) -> str:
    return "yes" if fits else "no"
