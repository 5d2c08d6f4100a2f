"""What is written is read again, bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from corpus_tools.logs.log_reading import read_log
from corpus_tools.logs.log_writing import to_bytes, write_log
from corpus_tools.world.state.recording import Recording, to_context
from g3.errors import FormatError
from tests.processes import python
from tests.strategies import recordings

ARRAYS = ("t_ns", "position", "orientation", "fork_height_m")
one_folder = settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])


def same(a: Recording, b: Recording) -> bool:
    return (
        a.start == b.start
        and a.steps == b.steps
        and all(getattr(a, name).tobytes() == getattr(b, name).tobytes() for name in ARRAYS)
    )


@one_folder
@given(recordings(), st.text(max_size=8), st.dictionaries(st.text(max_size=4), st.text(max_size=4)))
def test_a_log_reads_back_to_the_last_bit_and_is_written_with_the_same_bytes(
    tmp_path, recording, name, metadata
):
    path = tmp_path / "log.mcap"
    write_log(recording, path, name=name, metadata=metadata)
    log = read_log(path)
    assert same(log.recording, recording)
    assert (log.name, log.metadata) == (name, metadata)
    assert to_context(log.recording) == to_context(recording)
    again = to_bytes(log.recording, name=name, metadata=dict(reversed(metadata.items())))
    assert again == path.read_bytes()


def test_negative_zero_is_told_from_zero(tmp_path, driving):
    position = driving.position.copy()
    position[0, 0, 2], position[1, 0, 2] = 0.0, -0.0
    write_log(replace(driving, position=position), tmp_path / "a.mcap", name="", metadata={})
    read = read_log(tmp_path / "a.mcap").recording.position[:2, 0, 2]
    assert np.signbit(read).tolist() == [False, True]


def test_writing_to_a_missing_folder_is_told(tmp_path, driving):
    with pytest.raises(FormatError, match="there is no such folder"):
        write_log(driving, tmp_path / "none" / "a.mcap", name="", metadata={})


def test_a_log_replaces_the_file_and_leaves_no_other(tmp_path, driving):
    path = tmp_path / "a.mcap"
    path.write_bytes(b"old")
    write_log(driving, path, name="", metadata={})
    assert [p.name for p in tmp_path.iterdir()] == ["a.mcap"]
    assert same(read_log(path).recording, driving)


def test_logs_are_read_without_the_simulator():
    script = "import sys, corpus_tools.logs.log_reading; assert 'mujoco' not in sys.modules"
    assert python("-c", script).returncode == 0


def test_logs_need_no_simulator(tmp_path):
    program = f"""
import sys
for name in ("mujoco", "cv2", "av"):
    sys.modules[name] = None
from pathlib import Path
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.logs.log_reading import read_log
from corpus_tools.logs.log_writing import write_log
from corpus_tools.world.state.replay import replay
context = next(iter(open_corpus("warehouse").contexts.values()))
path = Path({str(tmp_path / "log.mcap")!r})
write_log(replay(context, 25.0), path, name="again", metadata={{}})
print(read_log(path).name)
"""
    done = python("-c", program)
    assert done.stdout == "again\n", done.stderr
