"""Finding scenarios and layouts by name."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.scenarios.scenario import Layout
from corpus_tools.world.scenarios.scenario_files import LAYOUTS, SCENARIOS
from corpus_tools.world.scenarios.scenario_reading import read_layout
from g3.errors import FormatError

DEFAULT = "warehouse"
"""The dataset where names are looked for if no other is given."""


def dataset_folder(name_or_path: str | Path) -> Path:
    """Return a dataset's folder: a folder as it is, or a bundled one by name; or FormatError."""
    path = Path(name_or_path)
    if path.is_dir():
        return path
    known = bundled()
    if str(name_or_path) not in known:
        raise FormatError.unknown("folder or bundled dataset", str(name_or_path), known)
    return known[str(name_or_path)]


def scenario_files(dataset: Path) -> dict[str, Path]:
    """Return the files of a dataset's scenarios by name, in the order of the names."""
    return {path.stem: path for path in sorted((dataset / SCENARIOS).glob("*.yaml"))}


def scenario_file(name_or_path: str, dataset: Path) -> Path:
    """Return a scenario's file: a file as it is, or one of a dataset by name; or FormatError."""
    path = Path(name_or_path)
    if path.is_file():
        return path
    known = scenario_files(dataset)
    if name_or_path not in known:
        raise FormatError.unknown(
            "file or scenario", name_or_path, known, more="ct scenarios list shows them"
        )
    return known[name_or_path]


def read_layouts(dataset: Path, names: Iterable[str] = ()) -> dict[str, Layout]:
    """Read a dataset's layouts by name; all of them if no names are given.

    FormatError if one isn't there, or something in it is wrong.
    """
    files = {path.stem: path for path in sorted((dataset / LAYOUTS).glob("*.yaml"))}
    for name in names:
        if name not in files:
            raise FormatError.unknown("layout", name, files, where=str(dataset))
    return {name: read_layout(files[name]) for name in (sorted(names) or files)}
