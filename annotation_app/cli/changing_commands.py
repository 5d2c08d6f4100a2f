"""What commands share that change an installation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from annotation_app.cli.command_options import Place, no_installation

if TYPE_CHECKING:
    from sqlalchemy.orm import Session


@contextmanager
def changing(place: Place, login: str = "", *, is_new_fine: bool = True) -> Iterator[Session]:
    """An installation's database, to be changed; refusals become errors of the command line."""
    from annotation_app.core.config import open_instance
    from annotation_app.core.problems import Refusal
    from annotation_app.serving import server as serving
    from annotation_app.serving.factory import create_app
    from annotation_app.store.database import opened, transaction

    if not (is_new_fine or place.database or place.instance.is_dir()):
        raise no_installation(place)
    config = open_instance(*place)
    serving.prepare(config)
    with opened(config.database) as engine:
        app = create_app(config, engine)
        try:
            with app.app_context(), transaction(engine) as session:
                yield session
        except Refusal as refusal:
            raise refusal.as_error(login) from None


def moment(at: Any) -> str:
    """A time for people, in UTC; "never" if there is none."""
    import datetime

    if at is None:
        return "never"
    return f"{datetime.datetime.fromtimestamp(at, datetime.timezone.utc):%Y-%m-%d %H:%M UTC}"
