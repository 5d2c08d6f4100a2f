"""What the core takes on the disk: ``python -m benchmarks.installed_size``.

The files of all distributions that it needs, as they lie in this environment, with compiled
modules. What isn't installed here is named and not counted.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import Distribution, PackageNotFoundError, distribution, requires
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from benchmarks.timing import aim, heading, show

PROJECT = "corpus-tools-g3"


def add(wanted: Iterable[str], found: dict[str, Distribution], missing: set[str]) -> None:
    """Add distributions that are required, and all that they require, without extras."""
    for requirement in map(Requirement, wanted):
        name = canonicalize_name(requirement.name)
        applies = requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        if not applies or name in found:
            continue
        try:
            found[name] = distribution(name)
        except PackageNotFoundError:
            missing.add(name)
            continue
        add(found[name].requires or (), found, missing)


def megabytes(one: Distribution) -> float:
    """What a distribution's files take, in 10⁶ bytes."""
    paths = {Path(str(path.locate())) for path in one.files or ()}
    return sum(path.stat().st_size for path in paths if path.is_file()) / 1e6


def main() -> None:
    found: dict[str, Distribution] = {}
    missing: set[str] = set()
    add(requires(PROJECT) or (), found, missing)
    sizes = {name: megabytes(one) for name, one in found.items()}
    heading("What the core needs")
    for name in sorted(sizes, key=sizes.__getitem__, reverse=True)[:8]:
        show(name, sizes[name], "MB")
    print(*(f"  not installed here: {name}" for name in sorted(missing)), sep="\n")
    whole = sum(sizes.values())
    what = "what the core needs beside itself, on the disk"
    aim(what, f"{whole:.0f} MB", "350 MB", reached=whole <= 350)


if __name__ == "__main__":
    main()
