"""pyarrow, which reads and writes Parquet: large, and not always installed."""

from __future__ import annotations

import io
from typing import Any

from corpus_tools.runtime.extras import import_extra


def import_pyarrow() -> tuple[Any, Any]:
    """Import ``pyarrow`` and ``pyarrow.parquet``; FormatError if pyarrow isn't installed."""
    purpose = "Parquet files are read and written"
    pyarrow = import_extra("pyarrow", "parquet", purpose)
    return pyarrow, import_extra("pyarrow.parquet", "parquet", purpose)


def parquet_bytes(table: Any, **options: Any) -> bytes:
    """Write a table of pyarrow to bytes; the options are those of ``write_table``."""
    _, pq = import_pyarrow()
    content = io.BytesIO()
    pq.write_table(table, content, **options)
    return content.getvalue()
