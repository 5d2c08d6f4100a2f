from __future__ import annotations

import pytest

from tests.processes import python

CHOOSE = "from corpus_tools.video.drawing.gl import choose_back_end; print(choose_back_end())"


def choose(program=CHOOSE, **environment):
    """Choose in a process of its own, with some of the environment's variables changed."""
    return python("-c", program, **{"MUJOCO_GL": "", "PYOPENGL_PLATFORM": "", **environment})


def test_a_back_end_is_found():
    assert choose().stdout.strip() in ("egl", "osmesa")


def test_the_users_choice_counts():
    assert choose(MUJOCO_GL="EGL").stdout.strip() == "egl"


@pytest.mark.parametrize(
    "environment",
    [
        # No display server, so GLFW has none; no driver, so EGL has none and OSMesa isn't there.
        {"MUJOCO_GL": "glfw", "DISPLAY": "", "WAYLAND_DISPLAY": ""},
        {"MUJOCO_GL": "egl", "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"},
    ],
)
def test_what_does_not_work_is_told_with_what_to_install(environment):
    result = choose(**environment)
    assert result.returncode != 0
    last = result.stderr.strip().splitlines()[-1]
    assert "CorpusError: no pictures can be drawn" in last
    assert "apt-get install libegl1 libgl1-mesa-dri" in last


def test_a_wrong_name_is_told():
    last = choose(MUJOCO_GL="vulkan").stderr.strip().splitlines()[-1]
    assert "'vulkan'" in last
    assert "osmesa" in last


@pytest.mark.parametrize("package", ["mujoco", "av", "cv2"])
def test_a_missing_package_is_told_with_what_installs_it(package):
    without = f"import sys; sys.modules[{package!r}] = None; "
    last = choose(without + CHOOSE).stderr.strip().splitlines()[-1]
    assert f"rendering needs packages that aren't installed: {package}" in last
    assert "pip install 'corpus-tools-g3[render]'" in last
