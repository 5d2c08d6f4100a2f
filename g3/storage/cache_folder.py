"""The folder of files that can be made again."""

from __future__ import annotations

import os
from pathlib import Path

CACHE = "corpus-tools-g3"


def cache_folder() -> Path:
    """Return the folder for cached files: in ``$XDG_CACHE_HOME``, else in ``~/.cache``."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    # The XDG specification has relative paths ignored.
    base = Path(given) if Path(given).is_absolute() else Path.home() / ".cache"
    return base / CACHE
