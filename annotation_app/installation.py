"""What a running app works with: its configuration, its database, and the time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from flask import Flask, current_app
from limits.strategies import MovingWindowRateLimiter
from sqlalchemy import Engine

from annotation_app.config import Config

if TYPE_CHECKING:
    from annotation_app.trying.queue import Attempts

_NAME = "annotation"


@dataclass(frozen=True, slots=True)
class Installation:
    """What a running app works with.

    Parameters
    ----------
    salt
        What hides people's ids.
    limiter
        Counts how often people do things; None if they may do so as often as they like.
    attempts
        The commands that people try.
    """

    config: Config
    engine: Engine
    salt: bytes
    limiter: MovingWindowRateLimiter | None
    attempts: Attempts


def install(app: Flask, installation: Installation) -> None:
    """Give an app what it works with."""
    app.extensions[_NAME] = installation


def installation() -> Installation:
    """What the app that handles this request works with."""
    return cast("Installation", current_app.extensions[_NAME])


def now() -> float:
    """Seconds since 1970."""
    return time.time()
