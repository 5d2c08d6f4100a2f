"""How often people may do things, counted by person, else by address."""

from __future__ import annotations

import flask
from flask_limiter import Limiter
from flask_limiter.util import get_remote_address

from annotation_app import counting  # noqa: F401 - makes process:// known


def whose() -> str:
    """Whom a request is counted for."""
    person_id = flask.session.get("person")
    return f"person {person_id}" if isinstance(person_id, str) else get_remote_address()


limiter = Limiter(whose, strategy="moving-window")
submissions = "240/minute"
arrivals = "120/minute"
"""New people who come by an open link, by address: a class may sit behind one."""
sign_ins = "10/minute;60/hour"
"""Passwords tried, by address."""
