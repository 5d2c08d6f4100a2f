"""Table 3 as text and as JSON, with how well the plans' probabilities tell right from wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from eval.statistics.comparison import Comparison
from eval.table_3.end_to_end import EndToEnd, table
from eval.table_3.outcomes import (
    JudgedRow,
    Outcome,
    grounding_accuracy,
    reliability,
    risk_coverage,
)
from eval.tables.comparison_report import NOTE, compare_commands, lines, records
from eval.tables.formats import document, interval

PAPER = {"random": 0.28, "gold-top30": 0.63, "auto-top30": 0.54, "gold-all": 0.47}
"""The paper's figures, which are people's judgments."""


def render(
    result: EndToEnd, form: Literal["text", "json"], *, draws: int = 2000, seed: int = 0
) -> str:
    """The rows of Table 3, and what else was measured."""
    rows = table(result, draws=draws, seed=seed)
    gold = result.outcomes.get("gold", ())
    error, diagram = reliability(gold) if gold else (float("nan"), [])
    compared = _compared(result, draws=draws, seed=seed)
    if form == "json":
        content: dict[str, object] = {
            "rows": rows,
            "object_grounding_top1": grounding_accuracy(gold),
            "expected_calibration_error": error,
            "reliability": diagram,
            "risk_coverage": {name: risk_coverage(own) for name, own in result.outcomes.items()},
            "comparisons": records(compared),
            "commands": {
                name: [_command(o) for o in outcomes] for name, outcomes in result.outcomes.items()
            },
        }
        return document(content, dict(result.metadata))
    return "\n".join([*_lines(rows), "", *lines(compared), NOTE, "", *_more(result)])


def _compared(result: EndToEnd, *, draws: int, seed: int) -> list[Comparison]:
    """Each two configurations on all commands, not only on those of which each is surest."""
    shares = {
        name: {o.command: float(o.correct) for o in outcomes}
        for name, outcomes in result.outcomes.items()
    }
    scenarios = {o.command: o.scenario for own in result.outcomes.values() for o in own}
    return compare_commands(shares, scenarios, draws=draws, seed=seed)


def _command(outcome: Outcome) -> dict[str, str | float | None]:
    return {
        "command": outcome.command,
        "text": outcome.text,
        "probability": round(outcome.probability, 4),
        "correct": int(outcome.correct),
        "reason": outcome.reason,
        "by_words": None if outcome.by_words is None else int(outcome.by_words),
        "words_reason": outcome.words_reason,
    }


def _lines(rows: Sequence[JudgedRow]) -> list[str]:
    lines = [
        f"{'':12}{'precision':>10}{'95%':>16}{'by words':>10}{'95%':>16}{'n':>6}{'paper':>8}"
        "   (automatic judge)"
    ]
    for row in rows:
        paper = PAPER.get(row["configuration"])
        bounds = interval(row["low"], row["high"], "[{:.2f}, {:.2f}]")
        shown = "" if paper is None else f"{paper:.2f}"
        name, value, words = row["configuration"], row["precision"], row["by_words"]
        around = interval(row["by_words_low"], row["by_words_high"], "[{:.2f}, {:.2f}]")
        by_words = "-" if math.isnan(words) else f"{words:.2f}"
        lines.append(
            f"{name:12}{value:10.2f}{bounds:>16}{by_words:>10}{around:>16}{row['n']:6}{shown:>8}"
        )
    return lines


def _more(result: EndToEnd) -> list[str]:
    told = {name: own for name, own in result.outcomes.items() if name != "random" and own}
    errors = [f"{reliability(own)[0]:.3f} ({name})" for name, own in told.items()]
    areas = [f"{risk_coverage(own):.3f} ({name})" for name, own in told.items()]
    accuracy = grounding_accuracy(result.outcomes.get("gold", ()))
    return [
        f"OBJECTs grounded as annotated: {accuracy:.2f}",
        f"expected calibration error of the plans' probabilities: {', '.join(errors)}",
        f"area under their risk-coverage curve: {', '.join(areas)}",
        "The verdicts are a program's. Precision: the plan ends where the command's own log ends.",
        "By words: it does what the words say. Comparisons, calibration and risk are of the first.",
        "The paper's are people's.",
    ]
