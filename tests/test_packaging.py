"""What is built and installed: the wheel, its extras, the lock file."""

from __future__ import annotations

import json
import re
import zipfile
from pathlib import Path

import pytest
import yaml
from hatchling.builders.wheel import WheelBuilder

import corpus_tools
from corpus_tools.runtime.extras import extra_of

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("annotation_app", "corpus_tools", "ct", "eval", "g3")
RUNTIME = (
    "", "app", "cluster", "embeddings", "language", "llm", "parquet", "plot", "render",
    "study",
)  # fmt: skip
OF_EPISODES = ("hdf5", "hub", "rlds", "ros")
"""Extras that are in neither *all* nor the lock file."""
NAME = re.compile(r"[\w.-]+")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    folder = tmp_path_factory.mktemp("dist")
    (path,) = WheelBuilder(str(ROOT)).build(directory=str(folder))
    return zipfile.ZipFile(path)


@pytest.fixture(scope="module")
def requirements(wheel) -> dict[str, list[str]]:
    """The names of required distributions by extra; those without one under ""."""
    (metadata,) = (n for n in wheel.namelist() if n.endswith(".dist-info/METADATA"))
    found: dict[str, list[str]] = {}
    for line in wheel.read(metadata).decode().splitlines():
        if line.startswith("Requires-Dist: "):
            needed = line.removeprefix("Requires-Dist: ")
            extra = re.search(r"extra == ['\"]([\w-]+)", needed)
            name = NAME.match(needed)
            assert name
            found.setdefault(extra[1] if extra else "", []).append(name[0])
    return found


def test_the_wheel_has_all_that_the_packages_read(wheel):
    there = set(wheel.namelist())
    files = [f for p in PACKAGES for f in (ROOT / p).rglob("*") if f.is_file()]
    wanted = {f.relative_to(ROOT).as_posix() for f in files if "__pycache__" not in f.parts}
    datasets = [f for f in (ROOT / "datasets").rglob("*") if f.is_file()]
    wanted |= {f"corpus_tools/{f.relative_to(ROOT).as_posix()}" for f in datasets}
    assert wanted - there == set()
    assert any(name.endswith("licenses/LICENSE") for name in there)


def test_the_wheel_has_nothing_else(wheel):
    tops = {name.split("/")[0] for name in wheel.namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == set(PACKAGES)


def test_the_core_is_light(requirements):
    heavy = {"mujoco", "spacy", "flask", "sqlalchemy", "pyarrow", "pandas", "scikit-learn"}
    assert not heavy & set(requirements[""])


def test_each_dependencys_licence_is_listed(requirements):
    page = (ROOT / "docs/contributing/dependencies.md").read_text()
    names = {name for extra in (*RUNTIME, *OF_EPISODES) for name in requirements[extra]}
    assert [name for name in sorted(names) if name not in page] == []


def test_the_lock_file_holds_all_and_names_no_host(requirements):
    lock = (ROOT / "requirements.lock").read_text()
    locked = set(re.findall(r"^([\w.-]+)==", lock, re.MULTILINE))
    names = {name for extra in RUNTIME for name in requirements[extra]}
    assert {n for n in names if n.lower() not in locked} == set()
    assert "://" not in lock


def test_the_bill_of_materials_is_of_what_is_locked():
    bill = json.loads((ROOT / "docs/sbom.cdx.json").read_text())
    lock = (ROOT / "requirements.lock").read_text()
    locked = re.findall(r"^([\w.-]+)==([\w.+-]+)", lock, re.MULTILINE)
    parts = bill["components"]
    assert [(part["name"], part["version"]) for part in parts] == sorted(locked)
    assert all(part["licenses"] for part in parts)
    assert bill["metadata"]["component"]["version"] == corpus_tools.__version__
    assert {d["ref"] for d in bill["dependencies"]} == {
        "corpus-tools-g3",
        *(part["bom-ref"] for part in parts),
    }
    assert "://" not in json.dumps(bill)


def test_a_missing_extra_can_be_named(requirements):
    assert extra_of("waitress") == "app"
    assert set(RUNTIME[1:]) < set(requirements)


def test_the_citation_is_of_this_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == corpus_tools.__version__
    assert citation["license"] == "MIT"


def test_the_installing_page_has_every_extra(requirements):
    page = (ROOT / "docs/installing.md").read_text()
    listed = set(re.findall(r"^\| `([\w-]+)` \|", page, re.MULTILINE))
    assert listed == {*RUNTIME[1:], *OF_EPISODES, "all"}


def test_the_workflow_checks_with_pythons_that_the_package_is_for():
    workflow = yaml.safe_load((ROOT / ".github/workflows/check.yml").read_text())
    job = workflow["jobs"]["check"]
    assert any(step.get("run") == "./check" for step in job["steps"])
    pythons = job["strategy"]["matrix"]["python"]
    listed = (ROOT / "pyproject.toml").read_text()
    assert len(pythons) == 3
    assert all(f"Python :: {one}" in listed for one in pythons)
    for form in (ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml"):
        assert yaml.safe_load(form.read_text()), form
