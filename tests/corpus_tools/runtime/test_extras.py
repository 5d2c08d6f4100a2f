import os
import subprocess
import sys

import pytest

from corpus_tools.runtime.extras import extra_of


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
    done = subprocess.run(
        [sys.executable, "-m", "corpus_tools", "annotate"],
        check=False,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert done.returncode == 2
    assert done.stderr == (
        "ct: error: this needs the package waitress (pip install 'corpus-tools-g3[app]')\n"
    )
