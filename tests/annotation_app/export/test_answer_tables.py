"""Exports are written as answers are read, whatever their number."""

from __future__ import annotations

import csv
import io
import tracemalloc

import msgspec
import pytest
from flask import Flask

from annotation_app.export.answer_tables import BATCH, FIELDS, TABLES, rows
from annotation_app.store.database import reading, transaction
from annotation_app.work.handing_out import find_study
from corpus_tools.exporters.csv_tables import safe_cell
from tests.annotation_app.browser import Browser, engine_of, exported
from tests.annotation_app.large_study import fill

ANSWERS = 2 * BATCH + 500


class Nowhere(io.RawIOBase):
    def writable(self) -> bool:
        return True

    def write(self, data: object) -> int:
        return len(memoryview(data))  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_files_have_the_bytes_of_all_rows_at_once(app: Flask) -> None:
    with transaction(engine_of(app)) as session:
        fill(session, ANSWERS)
    with reading(engine_of(app), one_state=True) as session:
        found = list(rows(session, find_study(session, "load")))
    assert len(found) == ANSWERS
    assert exported(app, "jsonl", "load") == msgspec.json.Encoder().encode_lines(found)
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(FIELDS)
    for row in found:
        as_json = {name: msgspec.json.encode(row[name]).decode() for name in ("body", "metadata")}
        writer.writerow([safe_cell((row | as_json)[name]) for name in FIELDS])
    assert exported(app, "csv", "load") == text.getvalue().encode()
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(io.BytesIO(exported(app, "parquet", "load")))
    assert table["answer"].to_pylist() == [row["answer"] for row in found]
    reply = Browser(app, "adjudicator").client.get("/dashboard/load/export/csv")
    assert reply.data == text.getvalue().encode()
    assert reply.content_length == len(reply.data)


@pytest.mark.parametrize("form", ["csv", "jsonl"])
def test_more_answers_take_no_more_memory(app: Flask, form: str) -> None:
    with transaction(engine_of(app)) as session:
        fill(session, 12 * BATCH)
    with reading(engine_of(app), one_state=True) as session:
        study = find_study(session, "load")
        tracemalloc.start()
        try:
            at_once = list(rows(session, study))
            _, whole = tracemalloc.get_traced_memory()
            del at_once
            tracemalloc.reset_peak()
            before, _ = tracemalloc.get_traced_memory()
            TABLES[form].write(session, study, Nowhere())  # type: ignore[arg-type]
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert peak - before < whole / 2
