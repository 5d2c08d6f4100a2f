"""Tables of answers as CSV, row by row."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import IO

from corpus_tools.exporters.csv_tables import safe_cell


def write_csv(file: IO[bytes], columns: Sequence[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a header and rows as UTF-8; no cell is taken for a formula. The file stays open."""
    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    try:
        writer = csv.writer(text)
        writer.writerow(columns)
        writer.writerows(map(safe_cell, row) for row in rows)
    finally:
        text.detach()
