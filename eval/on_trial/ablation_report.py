"""What each candidate wins and loses in each corpus, with a sign test: as text, JSON and CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypedDict

from rich.table import Table

from eval.on_trial.ablation_runs import NOTHING
from eval.statistics.comparison import holm
from eval.table_3.outcomes import Outcome
from eval.tables.formats import Format, cell, delimited, document, table_text

NOTES = (
    "won: commands that are right with it and wrong without it; lost: the other way round.",
    "p: two-sided exact sign test; Holm: corrected for all that was tried in the corpus.",
    "The verdict goes by won and lost alone; p says how easily that comes about by chance.",
)


class AblationRow(TypedDict):
    """A candidate in a corpus.

    ``n`` commands were followed, and in ``spoke`` of them the candidate says something. ``won``
    are right with it and wrong without it, ``lost`` the other way round. ``p`` is of the
    two-sided sign test, ``p_holm`` corrected for all candidates in the corpus.
    """

    name: str
    kind: str
    corpus: str
    n: int
    spoke: int
    won: int
    lost: int
    p: float
    p_holm: float


COLUMNS = tuple(AblationRow.__annotations__)


def rows(
    outcomes: Mapping[str, Mapping[str, Sequence[Outcome]]],
    candidates: Sequence[tuple[str, str]],
) -> list[AblationRow]:
    """A row for each corpus and candidate.

    Outcomes are by corpus and by what is switched off; those that aren't there were the same.
    """
    found: list[AblationRow] = []
    for corpus, by_candidate in outcomes.items():
        whole = {o.command: o.correct for o in by_candidate.get(NOTHING, ())}
        own: list[AblationRow] = []
        for name, kind in candidates:
            without = {o.command: o.correct for o in by_candidate.get(name, ())}
            won = sum(whole[c] and not right for c, right in without.items())
            lost = sum(right and not whole[c] for c, right in without.items())
            p = sign_test(won, lost)
            own.append(
                {
                    "name": name,
                    "kind": kind,
                    "corpus": corpus,
                    "n": len(whole),
                    "spoke": len(without),
                    "won": won,
                    "lost": lost,
                    "p": p,
                    "p_holm": p,
                }
            )
        for row, adjusted in zip(own, holm([row["p"] for row in own]), strict=True):
            row["p_holm"] = float(adjusted)
        found += own
    return found


def sign_test(won: int, lost: int) -> float:
    """Two-sided exact p of winning as often as losing; 1 where nothing changes."""
    from scipy.stats import binomtest  # noqa: PLC0415 - heavy

    return float(binomtest(won, won + lost).pvalue) if won + lost else 1.0


def verdict(own: Sequence[AblationRow]) -> str:
    """What a candidate's rows say together, by counts alone."""
    wins = sum(row["won"] > row["lost"] for row in own)
    loses = sum(row["won"] < row["lost"] for row in own)
    if wins and loses:
        return "wins in some and loses in others"
    if loses:
        return "loses"
    if wins:
        alone = "wins in one only" if len(own) > 1 else "wins"
        return f"wins in {wins} corpora" if wins > 1 else alone
    changes = any(row["won"] or row["lost"] for row in own)
    return "wins as much as it loses" if changes else "changes nothing"


def render(
    rows: Sequence[AblationRow],
    form: Format,
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """The rows, with a verdict on each candidate."""
    said = {name: verdict(own) for name, own in _by_name(rows)}
    if form == "csv":
        records = [{**row, "verdict": said[row["name"]]} for row in rows]
        return delimited(records, metadata, columns=(*COLUMNS, "verdict"))
    if form == "json":
        return document({"rows": rows, "verdicts": said}, metadata)
    table = Table("switched off", "kind")
    sizes = {row["corpus"]: row["n"] for row in rows}
    for corpus, n in sizes.items():
        table.add_column(cell(f"{corpus} ({n}): won"), justify="right")
        for heading in ("lost", "p", "Holm"):
            table.add_column(heading, justify="right")
    table.add_column("verdict")
    for name, own in _by_name(rows):
        cells = [text for row in own for text in _cells(row)]
        table.add_row(cell(name), own[0]["kind"], *cells, said[name])
    return table_text({"On trial": table}, NOTES, metadata, terminal=terminal)


def _by_name(rows: Sequence[AblationRow]) -> Iterator[tuple[str, list[AblationRow]]]:
    for name in dict.fromkeys(row["name"] for row in rows):
        yield name, [row for row in rows if row["name"] == name]


def _cells(row: AblationRow) -> tuple[str, str, str, str]:
    if not row["won"] + row["lost"]:
        return "0", "0", "-", "-"
    return str(row["won"]), str(row["lost"]), f"{row['p']:.3f}", f"{row['p_holm']:.3f}"
