"""Table 3 as text and as JSON, with how well the plans' probabilities tell right from wrong."""

from __future__ import annotations

from typing import Literal

from eval.end_to_end import EndToEnd, Row, grounding_accuracy, reliability, table
from eval.formats import document

PAPER = {"random": 0.28, "gold-top30": 0.63, "auto-top30": 0.54, "gold-all": 0.47}
"""The paper's figures, which are people's judgments."""


def render(
    result: EndToEnd, form: Literal["table", "json"], *, draws: int = 2000, seed: int = 0
) -> str:
    """The rows of Table 3, and what else was measured."""
    rows = table(result, draws=draws, seed=seed)
    gold = result.outcomes.get("gold", ())
    error, diagram = reliability(gold) if gold else (float("nan"), [])
    accuracy = grounding_accuracy(gold)
    if form == "json":
        content: dict[str, object] = {
            "rows": rows,
            "object_grounding_top1": accuracy,
            "expected_calibration_error": error,
            "reliability": diagram,
            "commands": {
                name: [_command(o.command, o.probability, o.correct, o.reason) for o in outcomes]
                for name, outcomes in result.outcomes.items()
            },
        }
        return document(content, dict(result.metadata))
    return "\n".join([*_lines(rows), "", *_more(accuracy, error)])


def _command(command: str, probability: float, correct: bool, reason: str) -> Row:
    return {
        "command": command,
        "probability": round(probability, 4),
        "correct": int(correct),
        "reason": reason,
    }


def _lines(rows: list[Row]) -> list[str]:
    lines = [f"{'':12}{'precision':>10}{'95%':>16}{'n':>6}{'paper':>8}   (automatic judge)"]
    for row in rows:
        paper = PAPER.get(str(row["configuration"]))
        interval = f"[{row['low']:.2f}, {row['high']:.2f}]"
        shown = "" if paper is None else f"{paper:.2f}"
        name, value = row["configuration"], row["precision"]
        lines.append(f"{name:12}{value:10.2f}{interval:>16}{row['n']:6}{shown:>8}")
    return lines


def _more(accuracy: float, error: float) -> list[str]:
    return [
        f"OBJECTs grounded as annotated: {accuracy:.2f}",
        f"expected calibration error of the plans' probabilities: {error:.3f}",
        "The verdicts are a program's: it compares what moved and where it ended with the",
        "command's own log. The paper's are people's.",
    ]
