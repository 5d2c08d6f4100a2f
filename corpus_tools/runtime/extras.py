"""Extras that bring packages which aren't installed."""

from __future__ import annotations

import importlib
import importlib.metadata
import re
from typing import Any

from g3.errors import FormatError

DISTRIBUTION = "corpus-tools-g3"

_REQUIREMENT = re.compile(r"([\w.-]+).*;.*extra == ['\"]([\w-]+)['\"]")
_REMEDY = re.compile(rf"pip install '{DISTRIBUTION}\[([\w-]+)\]'")
_COLLECTIONS = ("all", "test", "bench", "docs", "release", "dev")
"""Extras that bring others' packages, or only development tools."""
_MODULES = {
    "cv2": "opencv_python_headless",
    "google.protobuf": "protobuf",
    "mcap_protobuf": "mcap_protobuf_support",
}
"""Distributions of modules that have another name."""


def import_extra(module: str, extra: str, purpose: str) -> Any:
    """Import a module of an extra.

    Parameters
    ----------
    purpose
        Beginning of the error's sentence, such as "HDF5 files are read".
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        names = (name for of, name in _MODULES.items() if f"{module}.".startswith(f"{of}."))
        package = next(names, module.partition(".")[0]).replace("_", "-")
        raise FormatError(
            f"{purpose} with {package}, which isn't installed",
            fix=f"pip install '{DISTRIBUTION}[{extra}]'",
        ) from error


def extras() -> dict[str, list[str]]:
    """Return the distributions of each extra, except for extras of extras or of tools."""
    by_extra: dict[str, list[str]] = {}
    for requirement in importlib.metadata.requires(DISTRIBUTION) or ():
        match = _REQUIREMENT.fullmatch(requirement)
        if match and match[2] not in _COLLECTIONS:
            by_extra.setdefault(match[2], []).append(match[1])
    return dict(sorted(by_extra.items()))


def missing_of(extra: str) -> list[str]:
    """Return the distributions of an extra that aren't installed."""
    return [name for name in extras().get(extra, ()) if not _is_installed(name)]


def asked_extra(remedy: str) -> str | None:
    """Return the extra that a remedy asks to install; None if it names none, or it is there."""
    match = _REMEDY.search(remedy)
    return match[1] if match and missing_of(match[1]) else None


def _is_installed(name: str) -> bool:
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def extra_of(module: str) -> str | None:
    """Return the extra that brings an imported module (``flask.views``); None if none does."""
    top = module.partition(".")[0]
    distribution = _MODULES.get(top, top)
    brings = (e for e, names in extras().items() if _normal(distribution) in map(_normal, names))
    return next(brings, None)


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "_", name).lower()
