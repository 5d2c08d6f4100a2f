import os
import subprocess
import sys

import pytest

from g3.extensions import registering


def test_a_broken_extension_is_told_and_stops_nothing(tmp_path):
    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[ct.kinds]\ngone = there.is.no.such.module\n")
    code = "from corpus_tools.world.state.thing_kinds import KINDS; print('truck' in KINDS)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert done.stdout == "True\n"
    assert "ct.kinds: the extension gone can't be loaded: ModuleNotFoundError" in done.stderr


def test_a_function_is_registered_once_with_the_first_line_of_its_docs():
    known: dict[str, tuple[str, object]] = {}

    def wave() -> None:
        """Wave.

        With both hands.
        """

    decorate = registering(
        known, "wave", lambda about, function: (about, function), kind="greeting"
    )
    assert decorate(wave) is wave
    assert known == {"wave": ("Wave.", wave)}
    with pytest.raises(ValueError, match="the greeting 'wave' is registered already"):
        decorate(lambda: None)
    assert known == {"wave": ("Wave.", wave)}
