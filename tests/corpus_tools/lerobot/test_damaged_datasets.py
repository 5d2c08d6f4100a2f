"""Damaged datasets are read as they were, or refused by an error that names the place.

``CT_DAMAGES=20 pytest tests/corpus_tools/lerobot/test_damaged_datasets.py`` tries more than 1 500.
"""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from corpus_tools.lerobot.study_input import study_input
from g3.errors import CorpusError
from tests.damage import TIMES, damaged
from tests.lerobot_datasets import image_dataset, new_dataset, old_dataset

LENGTHS = (5, 4, 3)
SAID = (Language("task_aug", 0.0, "Do it."), Language("subtask", 0.0, "reach"))
KINDS: dict[str, Callable[..., Path]] = {
    "version 3": new_dataset,
    "version 2.1": old_dataset,
    "pictures": image_dataset,
}


@pytest.fixture(scope="module")
def datasets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("datasets")
    return {kind: make(folder / kind, lengths=LENGTHS) for kind, make in KINDS.items()}


def through(folder: Path, scratch: Path) -> int:
    """Import a dataset and write language into a copy; the number of episodes shown.

    An import that works is one whose export works: nobody is asked in vain.
    """
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    dataset = open_dataset(folder)
    made = study_input(dataset, scratch / "tables", scratch=scratch)
    language = {n: EpisodeLanguage(SAID, frozenset({"subtask"}), "Do it.") for n in range(3)}
    try:
        write_language(dataset, scratch / "copy", language, attachments={})
    except CorpusError as error:
        raise AssertionError(f"the import worked, and the export says: {error}") from error
    again = study_input(open_dataset(scratch / "copy"), scratch / "tables", scratch=scratch)
    assert again.rows["episodes.csv"] == made.rows["episodes.csv"]
    return made.rows["episodes.csv"]


def copy_of(dataset: Path, target: Path) -> Path:
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(dataset, target, copy_function=os.link)
    return target


def put(file: Path, content: bytes) -> None:
    file.unlink()
    file.write_bytes(content)


def damages(dataset: Path, seed: int) -> Iterator[tuple[str, str, bytes]]:
    """Each file of a dataset in some damaged forms."""
    for file in sorted(f for f in dataset.rglob("*") if f.is_file()):
        name = file.relative_to(dataset).as_posix()
        for how, content in damaged(file.read_bytes(), 2, seed=seed):
            yield name, how, content
            seed += 1


VALUES: tuple[Any, ...] = (
    None, True, 0.0, 0.5, -1, 2**62, 10**30, float("nan"), float("inf"), "", "0", "text", [],
    [None], ["a"], {}, {"a": 1}, b"\xff\xfe",
)  # fmt: skip
MISSING = object()
PARQUET = (
    "meta/episodes/chunk-000/file-000.parquet", "meta/tasks.parquet",
    "data/chunk-000/file-000.parquet",
)  # fmt: skip
JSON = (
    ("version 3", "meta/info.json"), ("version 2.1", "meta/info.json"),
    ("version 2.1", "meta/episodes.jsonl"), ("version 2.1", "meta/tasks.jsonl"),
)  # fmt: skip

T = TypeVar("T")


def some(every: Iterable[T]) -> list[T]:
    """Some of all, always the same; all where many damaged files are wanted."""
    listed = list(every)
    return random.Random(39).sample(listed, min(len(listed), 25 * TIMES))


def outcome(folder: Path, scratch: Path, what: str) -> bool:
    """Whether a dataset is taken; any other error than a named one fails the test."""
    try:
        return through(folder, scratch) > 0
    except CorpusError:
        return False
    except Exception as error:
        raise AssertionError(f"{what}: {error!r}") from error


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_refused_or_harmless(
    kind: str, datasets: dict[str, Path], tmp_path: Path
):
    taken = []
    for name, how, content in damages(datasets[kind], seed=39):
        folder = copy_of(datasets[kind], tmp_path / "set")
        put(folder / name, content)
        taken.append(outcome(folder, tmp_path / "scratch", f"{kind}: {name}: {how}"))
    assert len(taken) >= 12
    assert not all(taken)


def values_in_json(datasets: dict[str, Path]) -> Iterator[tuple[str, str, str, Any]]:
    for kind, name in JSON:
        first = json.loads((datasets[kind] / name).read_text().splitlines()[0])
        for field in first:
            for value in (MISSING, *(v for v in VALUES if not isinstance(v, bytes))):
                yield kind, name, field, value


@pytest.mark.slow
def test_values_of_other_types_in_json(datasets: dict[str, Path], tmp_path: Path):
    taken = []
    for kind, name, field, value in some(values_in_json(datasets)):
        folder = copy_of(datasets[kind], tmp_path / "set")
        lines = (folder / name).read_text().splitlines()
        row = json.loads(lines[0])
        del row[field]
        row |= {} if value is MISSING else {field: value}
        put(folder / name, "\n".join([json.dumps(row), *lines[1:]]).encode())
        what = f"{kind}: {name}: {field}={value!r}"
        taken.append(outcome(folder, tmp_path / "scratch", what))
    assert any(taken)
    assert not all(taken)


def values_in_parquet(datasets: dict[str, Path]) -> Iterator[tuple[str, str, Any]]:
    for name in PARQUET:
        for column in pq.read_schema(datasets["version 3"] / name).names:
            for value in (MISSING, *(v for v in VALUES if v != {} and v != 10**30)):
                yield name, column, value


@pytest.mark.slow
def test_columns_of_other_types(datasets: dict[str, Path], tmp_path: Path):
    taken = []
    for name, column, value in some(values_in_parquet(datasets)):
        folder = copy_of(datasets["version 3"], tmp_path / "set")
        table = pq.read_table(folder / name)
        place = table.column_names.index(column)
        other = table.remove_column(place)
        if value is not MISSING:
            other = table.set_column(place, column, pa.array([value] * len(table)))
        (folder / name).unlink()
        pq.write_table(other, folder / name)
        what = f"{name}: {column}={value!r}"
        taken.append(outcome(folder, tmp_path / "scratch", what))
    assert any(taken)
    assert not all(taken)


@pytest.mark.parametrize("kind", KINDS)
def test_folders_and_pipes_in_place_of_files(kind: str, datasets: dict[str, Path], tmp_path: Path):
    for file in sorted(f for f in datasets[kind].rglob("*") if f.is_file()):
        name = file.relative_to(datasets[kind]).as_posix()
        if name == "meta/stats.json" or "wrist" in name:
            continue  # nobody looks at these
        for make in (Path.mkdir, os.mkfifo):
            folder = copy_of(datasets[kind], tmp_path / "set")
            (folder / name).unlink()
            make(folder / name)
            with pytest.raises(CorpusError) as error:
                study_input(open_dataset(folder), tmp_path / "out", scratch=tmp_path / "films")
            assert Path(name).name in str(error.value)
