"""What a running app works with: its configuration, its database, and the time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import cast

from flask import Flask, current_app
from sqlalchemy import Engine

from annotation_app.config import Config

_NAME = "annotation"


@dataclass(frozen=True, slots=True)
class Installation:
    """An app's configuration, database, and the salt that hides people's ids."""

    config: Config
    engine: Engine
    salt: bytes


def install(app: Flask, installation: Installation) -> None:
    """Give an app what it works with."""
    app.extensions[_NAME] = installation


def installation() -> Installation:
    """What the app that handles this request works with."""
    return cast("Installation", current_app.extensions[_NAME])


def now() -> float:
    """Seconds since 1970."""
    return time.time()
