"""Damaged datasets are read as they were, or refused by an error that names the place.

``CT_DAMAGES=8 pytest tests/corpus_tools/lerobot/test_damaged_datasets.py`` tries more than 400.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

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
from tests.damage import damaged
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
        for how, content in damaged(file.read_bytes(), 3, seed=seed):
            yield name, how, content
            seed += 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_refused_or_harmless(
    kind: str, datasets: dict[str, Path], tmp_path: Path
):
    refused = tried = 0
    for name, how, content in damages(datasets[kind], seed=39):
        folder = copy_of(datasets[kind], tmp_path / "set")
        put(folder / name, content)
        tried += 1
        try:
            assert through(folder, tmp_path / "scratch") <= len(LENGTHS)
        except CorpusError as error:
            assert str(error)
            refused += 1
        except Exception as error:
            raise AssertionError(f"{kind}: {name}: {how}: {error!r}") from error
    assert tried >= 12
    assert refused > tried / 4


VALUES: tuple[Any, ...] = (
    None, True, 0.0, 0.5, -1, 2**62, 10**30, float("nan"), float("inf"), "", "0", "text", [], [None],
    ["a"], {}, {"a": 1}, b"\xff\xfe",
)  # fmt: skip


@pytest.mark.slow
def test_values_of_other_types_in_metadata(datasets: dict[str, Path], tmp_path: Path):
    worked = refused = 0
    for kind, name in (("version 3", "meta/info.json"), ("version 2.1", "meta/info.json"),
                       ("version 2.1", "meta/episodes.jsonl"), ("version 2.1", "meta/tasks.jsonl")):  # fmt: skip
        lines = (datasets[kind] / name).read_text().splitlines()
        first = json.loads(lines[0])
        for field in first:
            for value in (*(v for v in VALUES if not isinstance(v, bytes)), "MISSING"):
                folder = copy_of(datasets[kind], tmp_path / "set")
                row = {k: v for k, v in first.items() if k != field}
                row |= {} if value == "MISSING" else {field: value}
                put(folder / name, "\n".join([json.dumps(row), *lines[1:]]).encode())
                try:
                    worked += through(folder, tmp_path / "scratch") > 0
                except CorpusError:
                    refused += 1
                except Exception as error:
                    raise AssertionError(f"{kind}: {name}: {field}={value!r}: {error!r}") from error
    assert worked > 20
    assert refused > 100


def columns_of_types(count: int) -> Iterator[tuple[str, pa.Array]]:
    """Columns in which the first value has a type that it should not have."""
    for value in VALUES:
        try:
            if value == {}:
                continue  # Parquet has no such type
            yield f"first {value!r}", pa.array([value] * count)
        except (pa.ArrowException, OverflowError):
            continue


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["meta/episodes/chunk-000/file-000.parquet", "meta/tasks.parquet",
     "data/chunk-000/file-000.parquet"],
)  # fmt: skip
def test_columns_of_other_types(name: str, datasets: dict[str, Path], tmp_path: Path):
    worked = refused = 0
    table = pq.read_table(datasets["version 3"] / name)
    for place, column in enumerate(table.column_names):
        changed: list[tuple[str, pa.Table]] = [("missing", table.remove_column(place))]
        changed += [
            (how, table.set_column(place, column, array))
            for how, array in columns_of_types(len(table))
        ]
        for how, other in changed:
            folder = copy_of(datasets["version 3"], tmp_path / "set")
            (folder / name).unlink()
            pq.write_table(other, folder / name)
            try:
                worked += through(folder, tmp_path / "scratch") > 0
            except CorpusError:
                refused += 1
            except Exception as error:
                raise AssertionError(f"{name}: {column} {how}: {error!r}") from error
    assert worked
    assert refused


@pytest.mark.parametrize("kind", KINDS)
def test_folders_and_pipes_in_place_of_files(kind: str, datasets: dict[str, Path], tmp_path: Path):
    for file in sorted(f for f in datasets[kind].rglob("*") if f.is_file()):
        name = file.relative_to(datasets[kind]).as_posix()
        for make in (Path.mkdir, os.mkfifo):
            folder = copy_of(datasets[kind], tmp_path / "set")
            (folder / name).unlink()
            make(folder / name)
            if name == "meta/stats.json" or "wrist" in name:
                continue  # nobody looks at these
            with pytest.raises(CorpusError) as error:
                study_input(open_dataset(folder), tmp_path / "out", scratch=tmp_path / "films")
            assert Path(name).name in str(error.value)
