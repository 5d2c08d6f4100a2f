"""Places of the datasets that come with the toolkit, and its program."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

from corpus_tools import __version__

DATASET = "dataset.yaml"
"""The file that makes a folder a dataset."""

_PACKAGE = Path(__file__).resolve().parent.parent


@functools.cache
def program_digest(*folders: str) -> str:
    """Digest of the version, and of modules in folders of this package.

    In a checkout the program changes without its version.
    """
    digest = hashlib.sha256(__version__.encode())
    for folder in folders:
        for path in sorted((_PACKAGE / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def bundled() -> dict[str, Path]:
    """Return the folders of the bundled datasets by name."""
    # In a wheel the datasets are in the package, in a checkout beside it.
    for datasets in (_PACKAGE / "datasets", _PACKAGE.parent / "datasets"):
        if datasets.is_dir():
            return {path.parent.name: path.parent for path in sorted(datasets.glob(f"*/{DATASET}"))}
    return {}
