"""The check of ``ct doctor`` for the annotation app."""

from __future__ import annotations

import os
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from annotation_app.cli.installation_commands import DATABASE_VARIABLE
from g3.errors import CorpusError

if TYPE_CHECKING:
    from sqlalchemy import Engine


def database() -> str:
    """Check that the app's database can be used: the named one, or else a new SQLite file."""
    if find_spec("sqlalchemy") is None:
        raise CorpusError(
            "the annotation app needs packages that aren't installed",
            fix="pip install 'corpus-tools-g3[app]'",
        )
    from annotation_app.store.database import opened  # noqa: PLC0415 - comes with the extra "app"

    url = os.environ.get(DATABASE_VARIABLE)
    if url:
        with opened(url) as engine:
            return _state(engine)
    with tempfile.TemporaryDirectory() as folder, opened(Path(folder) / "new.sqlite") as engine:
        return _state(engine)


def _state(engine: Engine) -> str:
    from sqlalchemy.exc import SQLAlchemyError  # noqa: PLC0415 - comes with the extra "app"

    from annotation_app.store.schema import is_current  # noqa: PLC0415 - comes with the extra "app"

    try:
        current = is_current(engine)
    except SQLAlchemyError as error:
        reason = str(getattr(error, "orig", None) or error).splitlines()[0]
        raise CorpusError(
            f"the database can't be used: {reason}",
            where=engine.url.render_as_string(hide_password=True),
            fix=f"check the address in {DATABASE_VARIABLE}, and that the database exists",
        ) from error
    version = ".".join(map(str, engine.dialect.server_version_info or ()))
    state = (
        ""
        if engine.url.host is None
        else ", " + ("up to date" if current else "to be set up by `ct annotate`")
    )
    return f"{engine.dialect.name} {version}{state}"
