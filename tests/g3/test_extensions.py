import os
import subprocess
import sys


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
