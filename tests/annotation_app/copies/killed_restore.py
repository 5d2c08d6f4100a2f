"""A restore that is killed at one of its steps."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

from annotation_app.copies import restoring
from annotation_app.store import tombstones


def killed(*_: Any) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def restore_until(
    step: str, archive: Path, instance: Path, keys: Path, database: str | None
) -> None:
    """Restore a backup, and be killed at a step: keys, rows, migrated or end."""
    insert, seen = restoring._insert, []

    def insert_some(*arguments: Any) -> None:
        seen.append(arguments)
        insert(*arguments) if len(seen) < 5 else killed()

    if step == "keys":
        restoring.write_keys = killed
    elif step == "rows":
        restoring._insert = insert_some
    elif step == "migrated":
        restoring._set_sequences = restoring.erasure.erase_again = killed
    else:
        tombstones.keep = killed
    restoring.restore(archive, instance, database, keys=keys)
