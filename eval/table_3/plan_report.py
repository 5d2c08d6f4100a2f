"""Table 3 as text, JSON, CSV and LaTeX, with the reliability of plans' probabilities."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.estimate import Estimate, explained, named
from corpus_tools.runtime.text_tables import figure_table, table_lines, wrapped
from eval.judging.judge_registry import AUTOMATIC
from eval.judging.judge_report import in_a_line, with_validity
from eval.judging.judge_validity import known_validity
from eval.statistics.estimates import beside
from eval.table_3.end_to_end import EndToEnd
from eval.table_3.judged_commands import OUTCOMES, SUBSETS, Facts, Subset
from eval.table_3.outcomes import Outcome, grounding_accuracy, reliability, risk_coverage
from eval.table_3.plan_rows import (
    ALONE,
    COLUMNS,
    COMPARED,
    MODELS,
    VERDICTS,
    Compared,
    Row,
    comparisons,
    estimates_of,
    followed,
    rows,
)
from eval.tables import latex
from eval.tables.comparison_report import lines, records
from eval.tables.formats import Format, comments, delimited, document, figure, stated
from g3.errors import CorpusError

PAPER = {"random": 0.28, "gold-top30": 0.63, "auto-top30": 0.54, "gold-all": 0.47}
"""The paper's figures, which are people's judgments."""
TITLES: dict[str, str] = {
    "all": "all commands",
    "determined": "commands whose outcome is known (on any trailer that it may have been)",
    "two-or-more": "commands in worlds with two loads or more",
}
HEADINGS: dict[str, str] = {
    "precision": "precision",
    "by_words": "by words",
    "theme": "right load",
}
"""Headings of a verdict's column."""
NOTES = (
    "precision: plans of which all is right that is known, so that they end where the log ends; by",
    "words: plans that do what annotated words say; right load: plans that pick up the right thing",
    "and no other, so nothing where the robot only drove.",
    "95%: worlds resampled.",
    "chance: a load picked up at random; refused: commands without a plan, which count as wrong.",
    "random is the search with random costs; the baselines under it have no model; paper is the",
    "paper's own model, without potentials, rewriting and weights of plans.",
)
PEOPLE = "people: the interval for other worlds and other people."
MORE = "--verbose adds comparisons, intervals for other people, and how far to trust probabilities."
COMPARISON = (
    "compared on commands that both have: p is of no difference, by McNemar's test for pairs in "
    "clusters, which are worlds, exact where fewer than 10 of these differ, with Holm's correction "
    "in each list; h is Cohen's effect size"
)
NOT_VALIDATED = (
    "How well verdicts by outcomes agree with people isn't known: nobody has judged these videos."
)
JUDGED = (
    "The verdicts are a program's: it compares what moved and where it ended with the command's",
    "own log, or with its outcome where there is no log. The paper's are people's.",
)
JUDGED_OTHERWISE = (
    "precision is by a judge of your choice; by words and right load are by the automatic judge. "
    "`ct eval judge-validity --judge NAME` compares a judge with people.",
)


def table(result: EndToEnd, *, draws: int = 2000, seed: int = 0) -> list[Row]:
    """Return the rows of Table 3 (:mod:`eval.table_3.plan_rows`)."""
    lacking = [name for name in ALONE if name not in {*result.outcomes, *result.missing}]
    if lacking:
        raise CorpusError(
            f"Table 3 has no rows of {', '.join(lacking)}, which a model is compared with",
            fix="run it with all configurations",
        )
    judge = str(result.metadata.get("judge", AUTOMATIC))
    all_rows = rows(
        result.outcomes, result.facts, result.missing, draws=draws, seed=seed, judge=judge
    )
    for kind, own in result.perturbed.items():
        perturbed = rows(own, result.facts, {}, draws=draws, seed=seed, judge=judge)
        all_rows += [{**row, "perturbed": kind} for row in perturbed]
    return all_rows


def render(
    result: EndToEnd, form: Format, *, draws: int = 2000, seed: int = 0, verbose: bool = False
) -> str:
    """Render the rows of Table 3, and the other results.

    A text has comparisons, intervals for other people and calibration where `verbose` asks for it.
    """
    all_rows = table(result, draws=draws, seed=seed)
    if form == "csv":
        about = {key: value for key, value in result.metadata.items() if key not in COLUMNS}
        return delimited(all_rows, about, columns=COLUMNS)
    if form == "latex":
        return _latex(all_rows, result)
    compared = comparisons(result.outcomes, result.facts, draws=draws, seed=seed)
    if form == "json":
        return _document(result, all_rows, compared)
    shown = [
        line
        for c in compared
        for line in (
            *lines(c.comparisons, f"{HEADINGS[c.verdict]} compared on {TITLES[c.subset]}"),
            "",
        )
    ]
    estimates = (
        one for row in all_rows for verdict in VERDICTS for one in estimates_of(row, verdict)
    )
    notes = [*NOTES, *(f"{line}." for line in explained(estimates))]
    notes += [PEOPLE, ""] if verbose else []
    more = [*shown, COMPARISON, "", *_more(result)] if verbose else [MORE]
    text = [*notes, *more, *_judged(result)]
    return "\n".join([*_lines(all_rows, result, verbose=verbose), *wrapped(text)])


def with_judge(
    result: EndToEnd,
    corpora: Iterable[Corpus],
    *,
    draws: int,
    seed: int,
    notes: Sequence[str] = (),
    verbose: bool = False,
) -> Callable[[Format], str]:
    """Return a function that renders Table 3 with the validity of its verdicts, where known.

    Parameters
    ----------
    corpora
        The first that has people's judgments of videos with logs shows the automatic judge's
        validity.
    notes
        Further notes under the table.
    verbose
        Texts have comparisons too.
    """
    is_automatic = result.metadata.get("judge", AUTOMATIC) == AUTOMATIC
    is_by_logs = is_automatic and result.metadata.get("compared_with") != OUTCOMES
    validity = known_validity(corpora if is_by_logs else (), draws=draws, seed=seed)
    judge_notes = [in_a_line(validity) if is_by_logs else NOT_VALIDATED] if is_automatic else []

    def shown(form: Format) -> str:
        text = render(result, form, draws=draws, seed=seed, verbose=verbose)
        if form == "json":
            return with_validity(text, validity)
        return "\n".join([text, *wrapped([*notes, *judge_notes])]) if form == "text" else text

    return shown


def _document(result: EndToEnd, all_rows: Sequence[Row], compared: Iterable[Compared]) -> str:
    gold = result.outcomes.get("gold", ())
    error, diagram = reliability(gold)
    grounded = grounding_accuracy(gold)
    with_probability = {
        name: own
        for name, own in result.outcomes.items()
        if any(o.evidence or o.probability for o in own)
    }
    content: dict[str, object] = {
        "rows": all_rows,
        **named({"object_grounding_top1": grounded, "expected_calibration_error": error}),
        "reliability": diagram,
        "risk_coverage": {name: risk_coverage(own).value for name, own in with_probability.items()},
        "comparisons": [
            {"subset": c.subset, "verdict": c.verdict, **record}
            for c in compared
            for record in records(c.comparisons)
        ],
        "by_heading": list(_by_heading(result)),
        "commands": {
            name: [_command(o) for o in outcomes] for name, outcomes in result.outcomes.items()
        },
    }
    return document(content, dict(result.metadata))


def _command(outcome: Outcome) -> dict[str, object]:
    result: dict[str, object] = {
        "command": outcome.command,
        "text": outcome.text,
        "probability": round(outcome.probability, 4),
        "correct": int(outcome.correct),
        "theme": None if outcome.theme is None else int(outcome.theme),
        "refused": int(outcome.refused),
        "reason": outcome.reason,
        "by_words": None if outcome.by_words is None else int(outcome.by_words),
        "words_reason": outcome.words_reason,
    }
    return {**result, "heading": outcome.heading} if outcome.heading else result


def _by_heading(result: EndToEnd) -> Iterator[Row]:
    """Yield the shares in each heading, where there are several."""
    headings = dict.fromkeys(o.heading for own in result.outcomes.values() for o in own)
    for heading in headings if len(headings) > 1 else ():
        for subset in SUBSETS:
            for name, outcomes in result.outcomes.items():
                own = [
                    f
                    for f in followed([o for o in outcomes if o.heading == heading])
                    if result.facts.get(f.command, Facts()).is_in(subset)
                ]
                shares = {v: _mean([f.verdicts[v] for f in own]) for v in VERDICTS}
                about = {"heading": heading, "configuration": name, "subset": subset}
                yield {**about, "n": len(own), **shares}


def _mean(values: Sequence[float]) -> float:
    defined = [v for v in values if not np.isnan(v)]
    return float(np.mean(defined)) if defined else float("nan")


def _parts(all_rows: Sequence[Row]) -> Iterator[tuple[Subset, list[Row]]]:
    """Yield rows by part of the commands, without empty parts and copies of the whole."""
    total = max((row["n"] for row in all_rows), default=0)
    for subset in SUBSETS:
        own = [row for row in all_rows if row["subset"] == subset and not row["perturbed"]]
        most = max((row["n"] for row in own), default=0)
        if subset == "all" or 0 < most < total:
            yield subset, own


def _lines(all_rows: Sequence[Row], result: EndToEnd, *, verbose: bool) -> Iterator[str]:
    for subset, own in _parts(all_rows):
        yield f"{TITLES[subset]}   (judge: {own[0]['judge']})"
        yield from table_lines(_table(own, _papers(own, subset, result)))
        yield from wrapped(f"{row['configuration']}: {row['note']}" for row in own if row["note"])
        yield ""
        if verbose:
            yield from (*table_lines(_people(own)), "")
        if perturbed := _perturbed(own, [row for row in all_rows if row["subset"] == subset]):
            yield from (*table_lines(perturbed), "")
    headings = result.metadata.get("headings")
    if isinstance(headings, list) and len(headings) > 1:
        yield f"Each command was followed in {len(headings)} headings of the robot at the start:"
        shown = [r for r in _by_heading(result) if r["configuration"] in MODELS]
        for record in shown:
            shares = ", ".join(f"{HEADINGS[v]} {figure(record[v])}" for v in VERDICTS)
            yield f"  {record['heading']}, {record['configuration']}, {record['subset']}: {shares}"
        yield ""


def _papers(own: Sequence[Row], subset: Subset, result: EndToEnd) -> Mapping[str, float]:
    """Return the paper's figures beside rows; they are of its own corpus, or one like it."""
    if subset != "all" or "gold" not in result.outcomes:
        return {}
    is_authored = bool(result.metadata.get("is_authored"))
    papers = {str(row["configuration"]): row["n"] for row in own}
    shown = {
        name: beside(PAPER.get(name), n, is_authored=is_authored) for name, n in papers.items()
    }
    return {name: one for name, one in shown.items() if one is not None}


def _verdicts(all_rows: Iterable[Row]) -> list[str]:
    """Return the verdicts that any row has."""
    known = {v for row in all_rows for v in VERDICTS if not np.isnan(row[v])}
    return [v for v in VERDICTS if v in known]


def _table(own: Sequence[Row], papers: Mapping[str, float]) -> Table:
    verdicts = _verdicts(own)
    shares = (f"{HEADINGS[verdict]}, 95%" for verdict in verdicts)
    last = ("chance", "refused", "n", *(["paper"] if papers else []))
    table = figure_table(("", *shares, *last))
    for row in own:
        if row["note"]:
            continue
        name = str(row["configuration"])
        paper = [figure(papers.get(name))] if papers else []
        counts = (figure(row["chance"]), f"{row['refusals']:.4g}", str(row["n"]))
        table.add_row(Text(name), *(_share(row, v) for v in verdicts), *counts, *paper)
    return table


def _perturbed(own: Sequence[Row], all_rows: Sequence[Row]) -> Table | None:
    """Return a table of a part's shares beside those of the same commands perturbed, if any."""
    by_kind = {(row["configuration"], row["perturbed"]): row for row in all_rows}
    kinds = dict.fromkeys(str(row["perturbed"]) for row in all_rows if row["perturbed"])
    if not kinds:
        return None
    table = figure_table(("the same, perturbed", "", "as typed", *kinds), words=2)
    for name in (row["configuration"] for row in own):
        if (name, next(iter(kinds))) not in by_kind:
            continue
        for verdict in COMPARED:
            shares = [by_kind[name, kind][verdict] for kind in ("", *kinds)]
            if not all(np.isnan(shares)):
                table.add_row(Text(str(name)), HEADINGS[verdict], *map(figure, shares))
    return table


def _people(own: Sequence[Row]) -> Table:
    """Return a table of the intervals for other worlds and other people."""
    verdicts = _verdicts(own)
    table = figure_table(("people", *(HEADINGS[v] for v in verdicts)))
    for row in own:
        bounds = (_bounds(estimates_of(row, verdict)[1]) for verdict in verdicts)
        table.add_row(Text(str(row["configuration"])), *bounds)
    return table


def _share(row: Row, verdict: str) -> str:
    share, _ = estimates_of(row, verdict)
    return (
        f"{figure(share.value)} ({_bounds(share)})" if share.has_interval else figure(share.value)
    )


def _bounds(one: Estimate) -> str:
    """Format an interval, or a dash; notes have the reason."""
    return f"{one.low:.2f}-{one.high:.2f}" if one.has_interval else "-"


def _latex(all_rows: Sequence[Row], result: EndToEnd) -> str:
    tables = []
    named = (HEADINGS[v].capitalize() for v in VERDICTS)
    headings = ("", *named, "Chance", "Refused", "$n$")
    for subset, own in _parts(all_rows):
        cells = [
            (
                latex.text(str(row["configuration"])),
                *(latex.estimate(estimates_of(row, verdict)[0]) for verdict in VERDICTS),
                latex.estimate(Estimate(row["chance"])),
                str(row["refusals"]),
                str(row["n"]),
            )
            for row in own
        ]
        about = [*comments(result.metadata), f"Table 3, judge {own[0]['judge']}: {TITLES[subset]}."]
        about += [f"{row['configuration']} {row['note']}" for row in own if row["note"]]
        about += explained(estimates_of(row, verdict)[0] for row in own for verdict in VERDICTS)
        tables.append(latex.tabular(headings, cells, comments=about))
    return "\n\n".join(tables)


def _more(result: EndToEnd) -> list[str]:
    by_model: dict[str, Any] = {name: result.outcomes.get(name, ()) for name in MODELS}
    by_model = {name: own for name, own in by_model.items() if own}
    errors = [f"{stated(reliability(own)[0], '{:.3f}')} ({name})" for name, own in by_model.items()]
    areas = [f"{stated(risk_coverage(own), '{:.3f}')} ({name})" for name, own in by_model.items()]
    gold = result.outcomes.get("gold", ())
    accuracy = stated(grounding_accuracy(gold))
    grounded = [f"OBJECTs grounded as annotated: {accuracy}"] if gold else []
    return [
        *grounded,
        f"expected calibration error of the plans' probabilities: {', '.join(errors)}",
        f"area under their risk-coverage curve: {', '.join(areas)}",
        "",
    ]


def _judged(result: EndToEnd) -> Sequence[str]:
    is_automatic = result.metadata.get("judge", AUTOMATIC) == AUTOMATIC
    return JUDGED if is_automatic else JUDGED_OTHERWISE
