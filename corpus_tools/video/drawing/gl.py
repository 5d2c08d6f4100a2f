"""Choosing a way to draw without a screen."""

from __future__ import annotations

import functools
import importlib
import os
import subprocess
import sys
from importlib.util import find_spec
from typing import Any

from g3.errors import CorpusError

VARIABLE = "MUJOCO_GL"
"""The environment variable by which MuJoCo's users choose; ours too."""

BACK_ENDS = ("egl", "osmesa") if sys.platform == "linux" else ("glfw",)
"""In the order in which they are tried."""

PACKAGES = ("av", "cv2", "mujoco")
"""Packages of the extra ``render``, as they are imported."""

_KNOWN = ("egl", "osmesa", "glfw", "cgl", "wgl")
_PROBE_TIMEOUT_S = 60


def choose_back_end() -> str:
    """Find a back end that works and leave its name in the environment for child processes.

    ``MUJOCO_GL`` decides where it is set. Otherwise EGL is tried, which draws on a GPU or
    in software, then OSMesa, which draws in software. Each is tried in a process of its
    own: a library that was loaded once can't be exchanged.

    Raises
    ------
    CorpusError
        If none works, or not the chosen one, or a package is missing.
    """
    check_packages()
    chosen = os.environ.get(VARIABLE, "").lower()
    if chosen and chosen not in _KNOWN:
        raise CorpusError(
            f"{VARIABLE} is {chosen!r}, which draws nothing",
            fix=f"unset it, or set it to one of {', '.join(_KNOWN)}",
        )
    for name in (chosen,) if chosen else BACK_ENDS:
        if _works(name):
            os.environ[VARIABLE] = name
            return name
    raise CorpusError(
        f"no pictures can be drawn: {VARIABLE}={chosen} does not work here"
        if chosen
        else "no pictures can be drawn: neither EGL nor OSMesa works here",
        fix=f"{'unset it, or ' if chosen else ''}install the libraries; on Debian and Ubuntu: "
        "apt-get install libegl1 libgl1-mesa-dri, or libosmesa6",
    )


def check_packages() -> None:
    """Raise a CorpusError with the extra to install, if a package for rendering is missing."""
    missing = [name for name in PACKAGES if find_spec(name) is None]
    if missing:
        raise CorpusError(
            f"rendering needs packages that aren't installed: {', '.join(missing)}",
            fix="pip install 'corpus-tools-g3[render]'",
        )


def gl_context(width: int, height: int) -> Any:  # MuJoCo's back ends share no type
    """Create a context of the chosen back end; have its ``make_current`` and ``free`` called."""
    name = os.environ.get(VARIABLE) or choose_back_end()
    return importlib.import_module(f"mujoco.{name.lower()}").GLContext(width, height)


@functools.cache
def _works(name: str) -> bool:
    environment = {**os.environ, VARIABLE: name}
    # Left over from another back end, it would keep this one from loading.
    environment.pop("PYOPENGL_PLATFORM", None)
    try:
        probe = subprocess.run(  # noqa: S603 - our own interpreter and module
            [sys.executable, "-c", _PROBE],
            env=environment,
            capture_output=True,
            timeout=_PROBE_TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    return probe.returncode == 0


_PROBE = """
from corpus_tools.video.drawing.gl import gl_context
context = gl_context(16, 16)
context.make_current()
import mujoco
mujoco.MjrContext(mujoco.MjSpec().compile(), mujoco.mjtFontScale.mjFONTSCALE_100).free()
context.free()
"""
