"""Each extra alone is enough for what it promises, and the others are named where they are needed.

Packages that an extra doesn't bring can't be imported in these processes, as if they weren't
installed. `try_extras.py` does the same in real environments.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from corpus_tools.runtime.extras import DISTRIBUTION
from tests.annotation_app.rendered import render
from tests.test_containerfile import values

ALONE = (
    "app", "cluster", "embeddings", "language", "llm", "parquet", "plot", "render",
    "study",
)  # fmt: skip
RUN = """
import json, sys
from importlib.machinery import PathFinder
blocked, find_spec = set(json.loads(sys.argv.pop(1))), PathFinder.find_spec
def unblocked(name, path=None, target=None):
    return None if name.partition(".")[0] in blocked else find_spec(name, path, target)
PathFinder.find_spec = unblocked
from corpus_tools.cli.console import main
main()
"""
PATIENCE_S = 120.0

modules = functools.cache(packages_distributions)


def normal(name: str) -> str:
    return name.lower().replace("_", "-").replace(".", "-")


@functools.cache
def needed(extra: str) -> set[str]:
    """The distributions that the program has with an extra, and theirs in turn."""
    found: set[tuple[str, str]] = set()
    left = [(DISTRIBUTION, ""), (DISTRIBUTION, extra)]
    while left:
        name, of_extra = left.pop()
        if (normal(name), of_extra) in found:
            continue
        found.add((normal(name), of_extra))
        try:
            lines = requires(name) or ()
        except PackageNotFoundError:
            continue
        for line in lines:
            one = Requirement(line)
            if one.marker is None or one.marker.evaluate({"extra": of_extra}):
                left += [(one.name, ""), *((one.name, more) for more in one.extras)]
    return {name for name, _ in found}


def blocked(extra: str) -> list[str]:
    """The modules of all that other extras bring."""
    there, every = needed(extra), needed("all") | needed("cluster")
    return sorted(
        module
        for module, names in modules().items()
        if any(normal(n) in every for n in names) and not any(normal(n) in there for n in names)
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Videos, and a study of them."""
    made = tmp_path_factory.mktemp("extras")
    render(made / "videos")
    tasks = {"describe": {"answers": 1, "practice": False}}
    study = {"name": "small", "title": "Small", "videos": "videos", "tasks": tasks}
    (made / "study.yaml").write_text(json.dumps(study))
    return made


def command(extra: str, *line: str) -> list[str]:
    return [sys.executable, "-c", RUN, json.dumps(blocked(extra)), *line]


def environment(folder: Path) -> dict[str, str]:
    """Nothing is in the cache that another environment has made."""
    return os.environ | {"XDG_CACHE_HOME": str(folder / "cache"), "PYTHONUNBUFFERED": "1"}


def ct(extra: str, folder: Path, *line: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(extra, *line),
        check=False,
        capture_output=True,
        text=True,
        cwd=folder,
        env=environment(folder),
        timeout=PATIENCE_S,
    )


def serves(extra: str, folder: Path, *line: str) -> Iterator[str]:
    """The lines that a server prints, until it listens; it is ended then."""
    with subprocess.Popen(
        command(extra, *line),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=folder,
        env=environment(folder),
    ) as server:
        try:
            assert server.stdout is not None
            for text in server.stdout:
                yield text
                if "Ctrl-C" in text:
                    return
        finally:
            server.terminate()
            server.wait(PATIENCE_S)


def test_what_is_blocked_is_what_others_bring():
    assert {"cv2", "av", "mujoco", "pyarrow", "pandas", "spacy"} <= set(blocked("app"))
    assert not {"flask", "numpy", "click", "sqlalchemy", "jinja2"} & set(blocked("app"))
    assert "flask" in blocked("render")
    assert "cv2" not in blocked("render")


@pytest.mark.slow
def test_the_app_serves_alone(folder: Path, tmp_path: Path):
    """The lines of `docs/deployment.md`, and the container's."""
    for line in (["annotate", "serve", "study.yaml", "--port", "0"], ["annotate", "--port", "0"]):
        told = "".join(serves("app", folder, *line))
        assert "Ctrl-C" in told, told
    done = ct("app", folder, "annotate", "check", "study.yaml")
    assert done.returncode == 0, done.stderr
    (entry,), (rest,) = values("ENTRYPOINT"), values("CMD")
    _, *words = json.loads(entry) + json.loads(rest)
    words[words.index("--port") + 1] = "0"
    told = "".join(serves("app", tmp_path, *(w.replace("/data/", f"{tmp_path}/") for w in words)))
    assert "Ctrl-C" in told, told


@pytest.mark.slow
@pytest.mark.parametrize("extra", ALONE)
def test_what_is_missing_is_named_in_a_line(extra: str, folder: Path, tmp_path: Path):
    missing = "render" if extra == "app" else "app"  # the demo's videos are made first
    lines = [["annotate", "--port", "0"]]
    if extra != "app":
        lines += [["annotate", "check", str(folder / "study.yaml")]]
        lines += [["annotate", "serve", str(folder / "study.yaml"), "--port", "0"]]
    for line in lines:
        done = ct(extra, tmp_path, *line)
        assert done.returncode == 2, done.stderr
        assert f"corpus-tools-g3[{missing}]" in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1
