"""The database, for whoever asks for a page that only people with a role may see."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec, TypeAlias

from flask.typing import ResponseReturnValue as Reply
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.people.browser_sessions import required_person
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation
from annotation_app.store.models import Person, Role

P = ParamSpec("P")
Asked: TypeAlias = Iterator[tuple[Session, Person]]


@contextmanager
def seen_by(role: Role, *, one_state: bool = False) -> Asked:
    """Read the database for whose request this is, who must have a role.

    Raises
    ------
    Refusal
        As :func:`annotation_app.people.browser_sessions.required_person` does.
    """
    with reading(installation().engine, one_state=one_state) as session:
        yield session, required_person(session, role)


@contextmanager
def changed_by(role: Role) -> Asked:
    """Change the database for whose request this is, in the same way."""
    with transaction(installation().engine) as session:
        yield session, required_person(session, role)


def refused_on(
    page: Callable[..., str], role: Role = "admin"
) -> Callable[[Callable[P, Reply]], Callable[P, Reply]]:
    """Show somebody whose request is refused the page that it came from, with the reason why.

    Parameters
    ----------
    page
        Takes the database, the person, what the address names, and ``problem``.
    """

    def decorate(view: Callable[P, Reply]) -> Callable[P, Reply]:
        @functools.wraps(view)
        def shown(*args: P.args, **named: P.kwargs) -> Reply:
            try:
                return view(*args, **named)
            except Refusal as refusal:
                if refusal.status in (401, 403):
                    raise
                with seen_by(role) as (session, person):
                    return page(session, person, **named, problem=refusal.message), refusal.status

        return shown

    return decorate
