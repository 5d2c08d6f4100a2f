"""Options and sessions shared by the commands about an installation."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

DATABASE_VARIABLE = "CT_ANNOTATE_DATABASE"


class Place(NamedTuple):
    """An installation's place: its folder, and its database if that is no file there."""

    instance: Path
    database: str | None


def INSTALLATION(command: Callable[..., Any]) -> Callable[..., Any]:  # noqa: N802 - as options are
    """Add ``--instance`` and ``--database``; the command gets both as ``place``."""

    @click.option(
        "--instance",
        type=click.Path(path_type=Path, file_okay=False),
        default=Path("annotation"),
        show_default=True,
        help="Folder of the database and the secret key.",
    )
    @click.option(
        "--database",
        metavar="URL",
        envvar=DATABASE_VARIABLE,
        help="Database, such as postgresql://user@host/name [default: SQLite in the instance].",
    )
    @functools.wraps(command)
    def with_place(*args: Any, instance: Path, database: str | None, **options: Any) -> Any:
        return command(*args, place=Place(instance, database), **options)

    return with_place


@contextmanager
def changing(place: Place, login: str = "", *, is_new_fine: bool = True) -> Iterator[Session]:
    """Yield an installation's database for changes; refusals become command-line errors."""
    from annotation_app.core.config import existing_instance, open_instance
    from annotation_app.core.problems import Refusal
    from annotation_app.serving import server as serving
    from annotation_app.serving.factory import create_app
    from annotation_app.store.database import opened, transaction

    config = open_instance(*place) if is_new_fine else existing_instance(*place)
    serving.prepare(config)
    with opened(config.database) as engine:
        app = create_app(config, engine)
        try:
            with app.app_context(), transaction(engine) as session:
                yield session
        except Refusal as refusal:
            raise refusal.as_error(login) from None


@contextmanager
def existing(place: Place) -> Iterator[Session | None]:
    """Yield an installation's database, only read; None if there is none yet.

    Nothing is made: not the folder, nor the key. An error says if another program has made it.
    """
    from annotation_app.core.config import DATABASE_FILE, is_there
    from annotation_app.store.database import opened, reading
    from annotation_app.store.schema import check_current

    if not is_there(*place):
        yield None
        return
    with opened(place.database or place.instance / DATABASE_FILE) as engine:
        check_current(engine)
        with reading(engine, one_state=True) as session:
            yield session
