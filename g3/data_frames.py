"""Optional pandas export."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from g3.errors import CorpusError

if TYPE_CHECKING:
    import pandas as pd


def data_frame(rows: Iterable[Mapping[str, object]]) -> pd.DataFrame:
    """Return rows as a pandas table; columns of nested records get dotted names."""
    try:
        import pandas as pd  # noqa: PLC0415 - an extra, and heavy
    except ModuleNotFoundError as error:
        raise CorpusError(
            "to_pandas() needs pandas", fix="pip install pandas, or the extra study"
        ) from error
    return pd.json_normalize([dict(row) for row in rows])
