"""pyarrow, which reads and writes Parquet: large, and not always installed."""

from __future__ import annotations

import io
from typing import Any

from g3.errors import FormatError


def import_pyarrow() -> tuple[Any, Any]:
    """Import ``pyarrow`` and ``pyarrow.parquet``; FormatError if pyarrow isn't installed."""
    try:
        import pyarrow as pa  # noqa: PLC0415 - as the module says
        import pyarrow.parquet as pq  # noqa: PLC0415 - as above
    except ImportError as error:
        raise FormatError(
            "Parquet files are read and written with pyarrow, which isn't installed",
            fix="pip install 'corpus-tools-g3[parquet]'",
        ) from error
    return pa, pq


def parquet_bytes(table: Any, **options: Any) -> bytes:
    """Write a table of pyarrow to bytes; the options are those of ``write_table``."""
    _, pq = import_pyarrow()
    content = io.BytesIO()
    pq.write_table(table, content, **options)
    return content.getvalue()
