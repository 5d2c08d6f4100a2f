"""Outcomes of an unfinished Table 3, kept so that an interrupted run can be resumed."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from eval.table_3.outcomes import Outcome
from g3.short_repr import short_repr
from g3.storage.atomic_file import write_bytes

SUFFIX = ".part"
"""Suffix of the kept file, beside the table's own file."""

logger = logging.getLogger(__name__)

Outcomes = dict[str, list[Outcome]]


class _File(msgspec.Struct, frozen=True):
    settings: dict[str, Any]
    scenarios: dict[str, Outcomes]
    digest: str = ""


def _digest(content: _File) -> str:
    rest = msgspec.structs.replace(content, digest="")
    return f"sha256:{hashlib.sha256(msgspec.json.encode(rest, order='sorted')).hexdigest()}"


@short_repr
@dataclass(frozen=True, slots=True)
class Kept:
    """The outcomes of finished scenarios, by scenario and configuration."""

    path: Path
    settings: Mapping[str, object]
    scenarios: dict[str, Outcomes] = field(default_factory=dict)

    def keep(self, scenario: str, outcomes: Mapping[str, Sequence[Outcome]]) -> None:
        """Add a finished scenario."""
        self.scenarios[scenario] = {name: list(own) for name, own in outcomes.items()}
        content = _File(dict(self.settings), self.scenarios)
        sealed = msgspec.structs.replace(content, digest=_digest(content))
        write_bytes(self.path, msgspec.json.encode(sealed))


def kept_beside(out: Path, settings: Mapping[str, object]) -> Kept:
    """Return the outcomes kept by an earlier run of the same table; else none.

    A damaged file also gives none: its scenarios are run again. The settings decide the outcomes,
    in the form in which JSON has them.
    """
    path = out.with_name(f"{out.name}{SUFFIX}")
    try:
        known = msgspec.json.decode(path.read_bytes(), type=_File)
        damaged = known.digest != _digest(known)
    except FileNotFoundError:
        return Kept(path, settings)
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        damaged = True
    if damaged:
        logger.warning("%s: the file is damaged; what it kept is done again", path)
        return Kept(path, settings)
    same = known.settings == settings
    return Kept(path, settings, known.scenarios if same else {})
