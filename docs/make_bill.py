"""Make the bill of materials, ``sbom.cdx.json`` (CycloneDX), of what ``requirements.lock`` holds.

Licences and dependencies are what the packages say of themselves, so they are laid out first, for
two machines that between them need all that is locked::

    uv pip install --target build/linux --python-version 3.11 --no-deps -r requirements.lock
    uv pip install --target build/windows --python-version 3.13 --python-platform windows \
        --no-deps -r requirements.lock
    python docs/make_bill.py build/linux build/windows

The same packages give the same file: it holds no time and no number of its own.
"""

from __future__ import annotations

import json
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import Distribution, distributions
from pathlib import Path

from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import corpus_tools

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "docs/sbom.cdx.json"
PRODUCT = "corpus-tools-g3"
EXTRAS = {PRODUCT: {"all", "cluster"}}
"""Extras of each package that the lock file covers."""
MACHINES: tuple[Mapping[str, str], ...] = (
    {"python_version": "3.11", "python_full_version": "3.11.9", "sys_platform": "linux"},
    {"python_version": "3.13", "python_full_version": "3.13.1", "sys_platform": "win32"},
)
SPDX = {
    "2-clause BSD": "BSD-2-Clause",
    "Apache 2.0": "Apache-2.0",
    "Apache License 2.0": "Apache-2.0",
    "Apache Software License": "Apache-2.0",
    "Apache-2.0": "Apache-2.0",
    "BSD-2-Clause": "BSD-2-Clause",
    "BSD-3-Clause": "BSD-3-Clause",
    "ISC License": "ISC",
    "MIT": "MIT",
    "MIT License": "MIT",
    "MPL-2.0": "MPL-2.0",
    "ZPL 2.1": "ZPL-2.1",
}
"""Licences that packages name otherwise than SPDX does."""

_LOCKED = re.compile(r"^([\w.-]+)==([\w.+-]+)", re.MULTILINE)


def bill(folders: Sequence[str]) -> Mapping[str, object]:
    """Return the document.

    Parameters
    ----------
    folders
        In which the locked packages are.
    """
    locked = sorted(_LOCKED.findall((ROOT / "requirements.lock").read_text()))
    found = {
        (canonicalize_name(d.metadata["Name"]), d.version): d
        for d in distributions(path=[*folders])
    }
    missing = [f"{name} {version}" for name, version in locked if (name, version) not in found]
    if missing:
        raise SystemExit(f"not in {' '.join(folders)}: {', '.join(missing)}")
    product = next(iter(distributions(name=PRODUCT)))
    packages = [product, *(found[key] for key in locked)]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {
            "component": {
                "type": "application",
                "bom-ref": PRODUCT,
                "name": PRODUCT,
                "version": corpus_tools.__version__,
                "licenses": licences(product),
            }
        },
        "components": [component(name, version, found[name, version]) for name, version in locked],
        "dependencies": dependencies(packages, locked),
    }


def component(name: str, version: str, package: Distribution) -> Mapping[str, object]:
    """Return a package's entry in the document."""
    return {
        "type": "library",
        "bom-ref": f"{name}=={version}",
        "name": name,
        "version": version,
        "licenses": licences(package),
        "purl": f"pkg:pypi/{name}@{version}",
    }


def licences(package: Distribution) -> list[Mapping[str, object]]:
    """Return the licence that a package states: an SPDX expression, or names."""
    about = package.metadata
    expression = about.get("License-Expression")
    if expression:
        return [{"expression": expression}]
    told = (about.get("License") or "").strip()
    if " AND " in told and "\n" not in told:
        return [{"expression": told}]
    lines = [line for line in about.get_all("Classifier") or () if line.startswith("License")]
    classified = [line.rpartition(" :: ")[2] for line in lines]
    names = [told] if told in SPDX or not classified else classified
    if not all(names):
        raise SystemExit(f"{about['Name']} tells no licence")
    return [{"license": {"id": SPDX[n]} if n in SPDX else {"name": n}} for n in names]


def dependencies(
    packages: Iterable[Distribution], locked: Iterable[tuple[str, str]]
) -> list[Mapping[str, object]]:
    """Return the dependencies of each package, on one of the machines at least."""
    versions: dict[str, set[str]] = defaultdict(set)
    for name, version in locked:
        versions[name].add(f"{name}=={version}")
    needs = {_reference(p): [Requirement(line) for line in p.requires or ()] for p in packages}
    wanted: dict[str, set[str]] = defaultdict(set, EXTRAS)
    for requirements in needs.values():
        for requirement in requirements:
            wanted[canonicalize_name(requirement.name)] |= requirement.extras
    return [
        {
            "ref": reference,
            "dependsOn": sorted(
                {
                    one
                    for requirement in requirements
                    if _applies(requirement.marker, {"", *wanted[reference.partition("==")[0]]})
                    for one in versions[canonicalize_name(requirement.name)]
                }
            ),
        }
        for reference, requirements in sorted(needs.items())
    ]


def _reference(package: Distribution) -> str:
    name = canonicalize_name(package.metadata["Name"])
    return name if name == PRODUCT else f"{name}=={package.version}"


def _applies(marker: Marker | None, extras: Iterable[str]) -> bool:
    return marker is None or any(
        marker.evaluate({**machine, "extra": extra}) for machine in MACHINES for extra in extras
    )


if __name__ == "__main__":
    OUT.write_text(json.dumps(bill(sys.argv[1:]), indent=1) + "\n", encoding="utf-8")
