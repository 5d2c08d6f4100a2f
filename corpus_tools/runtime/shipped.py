"""Where the datasets are that come with the toolkit."""

from __future__ import annotations

from pathlib import Path

DATASET = "dataset.yaml"
"""The file that makes a folder a dataset."""

_PACKAGE = Path(__file__).resolve().parent.parent


def bundled() -> dict[str, Path]:
    """The folders of the bundled datasets by name."""
    # In a wheel the datasets are in the package, in a checkout beside it.
    for datasets in (_PACKAGE / "datasets", _PACKAGE.parent / "datasets"):
        if datasets.is_dir():
            return {path.parent.name: path.parent for path in sorted(datasets.glob(f"*/{DATASET}"))}
    return {}
