"""Resources of a running app: its configuration, its database, and the time."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import cast

from flask import Flask, current_app
from limits.strategies import MovingWindowRateLimiter
from sqlalchemy import Engine

from annotation_app.core.config import Config
from annotation_app.store.outages import Outages

_NAME = "annotation"


@dataclass(frozen=True, slots=True)
class Installation:
    """Resources of a running app."""

    config: Config
    engine: Engine
    salt: bytes
    """Salt that hides people's ids."""
    limiter: MovingWindowRateLimiter | None
    """Counts how often people do things; None if they may do so as often as they like."""
    outages: Outages = field(default_factory=Outages)
    """Logs what goes wrong outside of the program."""


def install(app: Flask, installation: Installation) -> None:
    """Give an app what it works with."""
    app.extensions[_NAME] = installation


def installation() -> Installation:
    """Return the resources of the app that handles this request."""
    return cast("Installation", current_app.extensions[_NAME])


def now() -> float:
    """Return the time in seconds since 1970."""
    return time.time()
