from __future__ import annotations

import os
import shutil
import threading
import time
import zipfile
from pathlib import Path

import pytest

import corpus_tools
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored import authored_corpus as assembly
from corpus_tools.importers.authored import bundled
from g3.errors import FormatError
from g3.storage.cache_folder import cache_folder
from tests.processes import python

ROOT = Path(corpus_tools.__file__).resolve().parent.parent


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "corpus-tools-g3"


@pytest.fixture(scope="module")
def imported():
    return assembly.import_authored(bundled.bundled()["warehouse"])


@pytest.fixture
def quick(monkeypatch, imported):
    """The import, done once for all tests; what is tested here is what is made of it."""
    monkeypatch.setattr(assembly, "import_authored", lambda source: imported)


def test_warehouse_is_built_once_into_the_cache(cache, monkeypatch, quick):
    path = bundled.resolve("warehouse")
    assert path.parent == cache
    assert Corpus.load(path).name == "warehouse"
    monkeypatch.setattr(assembly, "import_authored", None)
    assert bundled.resolve("warehouse") == path
    assert len(bundled.open_corpus("warehouse").commands) >= 80
    assert [*cache.iterdir()] == [path]


def test_a_folder_is_itself(tmp_path):
    assert bundled.resolve(tmp_path) == tmp_path
    assert bundled.resolve(str(tmp_path)) == tmp_path


def test_a_folder_goes_before_a_bundled_name(tmp_path, monkeypatch):
    (tmp_path / "warehouse").mkdir()
    monkeypatch.chdir(tmp_path)
    assert bundled.resolve("warehouse") == Path("warehouse")


def test_the_sources_stand_for_their_corpus(quick):
    assert bundled.resolve(bundled.bundled()["warehouse"]) == bundled.resolve("warehouse")


def test_unknown_names_are_told_the_known_ones():
    with pytest.raises(FormatError, match="did you mean 'warehouse'"):
        bundled.resolve("warehose")


def test_changed_sources_are_built_anew(tmp_path):
    source = shutil.copytree(
        bundled.bundled()["warehouse"],
        tmp_path / "mine",
        ignore=lambda folder, names: names[2:] if folder.endswith("scenarios") else [],
    )
    first = bundled.resolve(source)
    dataset = source / "dataset.yaml"
    dataset.write_text(dataset.read_text().replace("seed: 2011", "seed: 1"))
    second = bundled.resolve(source)
    assert first != second
    assert Corpus.load(first).hash != Corpus.load(second).hash


def test_a_cached_corpus_with_a_missing_file_is_built_anew(quick):
    path = bundled.resolve("warehouse")
    (path / "annotations.jsonl").unlink()
    assert bundled.resolve("warehouse") == path
    assert Corpus.load(path).annotations


def test_what_older_programs_built_is_kept_for_a_month(cache, quick):
    days = {"0" * 16: 40, "1" * 16: 20}
    for digest, age in days.items():
        (cache / f"warehouse-{digest}").mkdir(parents=True)
        ago = time.time() - age * 24 * 3600
        os.utime(cache / f"warehouse-{digest}", (ago, ago))
    built = bundled.resolve("warehouse")
    assert set(cache.iterdir()) == {built, cache / f"warehouse-{'1' * 16}"}


def test_builds_at_the_same_time_agree(cache, quick):
    found: list[Path] = []
    threads = [
        threading.Thread(target=lambda: found.append(bundled.resolve("warehouse")))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    assert set(found) == set(cache.iterdir())
    assert Corpus.load(found[0]).annotations


def test_a_cache_that_cannot_be_written_is_told(tmp_path, monkeypatch, quick):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(FormatError, match="XDG_CACHE_HOME"):
        bundled.resolve("warehouse")


def test_the_cache_is_in_the_home_folder_by_default(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    for value in ("", "relative"):
        monkeypatch.setenv("XDG_CACHE_HOME", value)
        assert cache_folder() == tmp_path / ".cache" / "corpus-tools-g3"


@pytest.mark.slow
def test_a_wheel_brings_the_dataset_along(tmp_path):
    builders = pytest.importorskip("hatchling.builders.wheel")
    builder = builders.WheelBuilder(str(ROOT))
    built = next(builder.build(directory=str(tmp_path), versions=["standard"]))
    with zipfile.ZipFile(built) as wheel:
        wheel.extractall(tmp_path / "site")
    program = (
        "import corpus_tools; from corpus_tools.importers.authored.bundled import open_corpus; "
        "print(corpus_tools.__file__, len(open_corpus('warehouse').commands))"
    )
    result = python("-c", program, cwd=tmp_path, PYTHONPATH=str(tmp_path / "site"))
    file, commands = result.stdout.split()
    assert Path(file).is_relative_to(tmp_path / "site")
    assert int(commands) >= 80


def test_simulated_ratings_are_of_the_bundled_corpus_and_labelled():
    rated, warehouse = (
        bundled.open_corpus(name) for name in ("warehouse-simulated-ratings", "warehouse")
    )
    assert rated.commands == warehouse.commands
    assert {j.study for j in rated.judgments} == {"simulated"}
    assert {j.subject.partition("-")[0] for j in rated.judgments} == {"simulated"}
    assert len(rated.judgments) == 2 * 5 * len(rated)
    assert "simulated" in rated.source
    assert rated.is_authored
    assert not warehouse.judgments


def test_a_rated_dataset_that_cant_be_read_is_named(tmp_path):
    (tmp_path / "dataset.yaml").write_text("name: mine\nsource: x\nlicence: x\n")
    (tmp_path / "raters.yaml").write_text("corpus: warehouse\nraters: many\n")
    with pytest.raises(FormatError, match=r"raters\.yaml"):
        bundled.open_corpus(tmp_path)
    (tmp_path / "raters.yaml").write_text("corpus: ware\nraters: 9\njudgments: 3\nseed: 1\n")
    with pytest.raises(FormatError, match="'ware'"):
        bundled.open_corpus(tmp_path)
