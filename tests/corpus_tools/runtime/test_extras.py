import importlib.metadata
import os
import re
from pathlib import Path

import pytest

from corpus_tools.doctor import machine_checks
from corpus_tools.runtime.extras import extra_of, extras, missing_of
from tests.processes import ct

PYPROJECT = (Path(__file__).parents[3] / "pyproject.toml").read_text()
_EXTRAS = PYPROJECT.partition("[project.optional-dependencies]\n")[2].partition("\n\n")[0]
RUNTIME = set(re.findall(r"^([\w-]+) = ", _EXTRAS, re.MULTILINE)) - {
    "all", "test", "docs", "release", "bench", "dev",
}  # fmt: skip
"""The extras that add something for users, as pyproject.toml has them."""


@pytest.mark.parametrize(
    ("module", "extra"),
    [
        ("flask_wtf.csrf", "app"),
        ("psycopg", "app"),
        ("cv2", "render"),
        ("mujoco", "render"),
        ("spacy", "language"),
        ("statsmodels.api", "study"),
        ("distributed", "cluster"),
        ("numpy", None),
        ("there_is_none", None),
    ],
)
def test_the_extra_of_a_module(module, extra):
    assert extra_of(module) == extra


def test_a_command_whose_extra_is_missing_names_it(tmp_path):
    (tmp_path / "sitecustomize.py").write_text("import sys; sys.modules['waitress'] = None\n")
    done = ct("annotate", cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert done.returncode == 2
    assert done.stderr == (
        "ct: error: this needs the package waitress (pip install 'corpus-tools-g3[app]')\n"
    )


def test_a_study_is_begun_without_any_extra(tmp_path):
    gone = ["babel", "flask", "sqlalchemy", "cv2", "av", "mujoco", "spacy", "pyarrow"]
    (tmp_path / "sitecustomize.py").write_text(f"import sys; sys.modules |= dict.fromkeys({gone})")
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    done = ct("annotate", "init", "my study.yaml", cwd=tmp_path, PYTHONPATH=path)
    assert done.returncode == 0, done.stderr
    assert "name: my-study" in (tmp_path / "my study.yaml").read_text()


def test_what_extras_bring(monkeypatch):
    assert set(extras()) == RUNTIME
    assert {"flask", "sqlalchemy"} <= set(extras()["app"])
    assert missing_of("study") == []
    version = importlib.metadata.version

    def without_dask(name):
        if name == "distributed":
            raise importlib.metadata.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(importlib.metadata, "version", without_dask)
    assert missing_of("cluster") == ["distributed"]
    remark = machine_checks.extras()
    assert "cluster (distributed)" in remark.found
    assert remark.fix.endswith("pip install 'corpus-tools-g3[cluster]'")


def test_the_doctor_looks_at_every_extra():
    named = machine_checks.extras().split(", ")
    assert set(named) == RUNTIME
