"""Damaged logs are refused with the file's name, or read as they were."""

from __future__ import annotations

import io

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer

from corpus_tools.logs.log_reading import read_log
from corpus_tools.logs.log_writing import to_bytes, write_log
from g3.errors import FormatError

one_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


@one_folder
@given(fraction=st.floats(0, 1, exclude_max=True))
def test_a_log_that_is_cut_off_is_refused(tmp_path, driving, fraction):
    content = to_bytes(driving, name="", metadata={})
    path = tmp_path / "cut.mcap"
    path.write_bytes(content[: int(fraction * len(content))])
    with pytest.raises(FormatError) as caught:
        read_log(path)
    assert str(path) in caught.value.where
    assert caught.value.fix


@one_folder
@given(fraction=st.floats(0, 1, exclude_max=True), mask=st.integers(1, 255))
def test_a_flipped_byte_is_found_or_does_no_harm(tmp_path, driving, fraction, mask):
    content = bytearray(to_bytes(driving, name="", metadata={}))
    content[int(fraction * len(content))] ^= mask
    path = tmp_path / "flipped.mcap"
    path.write_bytes(content)
    try:
        log = read_log(path)
    except FormatError as error:
        found = error.where
    else:
        found = str(path)
        assert log.recording.position.tobytes() == driving.position.tobytes()
        assert log.recording.start == driving.start
        assert log.recording.steps == driving.steps
    assert str(path) in found


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(FormatError, match="can't be read: No such file"):
        read_log(tmp_path / "none.mcap")


def test_a_folder_is_told(tmp_path):
    with pytest.raises(FormatError, match="can't be read: Is a directory"):
        read_log(tmp_path)


def test_another_programs_mcap_file_is_told(tmp_path):
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    writer.finish()
    (tmp_path / "other.mcap").write_bytes(stream.getvalue())
    with pytest.raises(FormatError, match="no log of a world"):
        read_log(tmp_path / "other.mcap")


def rewritten(recording, change):
    """The log with each message's content changed by `change(topic, data)`, None to drop it."""
    source = make_reader(io.BytesIO(to_bytes(recording, name="", metadata={})))
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    for metadata in source.iter_metadata():
        writer.add_metadata(metadata.name, metadata.metadata)
    numbers = {}
    for _, channel, message in source.iter_messages():
        data = change(channel.topic, message.data)
        if data is not None:
            if channel.topic not in numbers:
                numbers[channel.topic] = writer.register_channel(channel.topic, "json", 0)
            writer.add_message(
                numbers[channel.topic], message.log_time, data, message.log_time, message.sequence
            )
    writer.finish()
    return stream.getvalue()


@pytest.mark.parametrize("topic", ["/context", "/steps", "/tf", "/robot"])
def test_a_missing_channel_is_told(tmp_path, driving, topic):
    path = tmp_path / "a.mcap"
    path.write_bytes(rewritten(driving, lambda t, data: None if t == topic else data))
    with pytest.raises(FormatError) as caught:
        read_log(path)
    assert caught.value.where == str(path)


@pytest.mark.parametrize(
    ("topic", "old", "new", "what"),
    [
        ("/tf", b'"x":1.1', b'"x":null', r"transforms\[1\].translation.x: expected `float`"),
        ("/robot", b'"fork_height_m":0.41', b'"fork_height_m":"up"', "/robot at 1 s: fork_height"),
        ("/context", b'"agent_id":"robot"', b'"agent_id":"truck"', "agent is none of them"),
        ("/context", b'"z_max":0.7', b'"z_max":-0.7', "are not an interval"),
        (
            "/context",
            b'"labels":',
            b'"colours":["mauve"],"labels":',
            "colours must be black, white",
        ),
        ("/steps", b'"steps"', b'"stops"', "unknown field `stops`"),
        ("/robot", b'{"timestamp"', b'{timestamp"', "malformed"),
    ],
)
def test_wrong_messages_are_told_with_their_place(tmp_path, driving, topic, old, new, what):
    path = tmp_path / "a.mcap"
    change = lambda t, data: data.replace(old, new) if t == topic else data  # noqa: E731
    path.write_bytes(rewritten(driving, change))
    with pytest.raises(FormatError, match=what) as caught:
        read_log(path)
    assert str(path) in caught.value.where


def test_a_log_of_a_later_format_is_told(tmp_path, driving, monkeypatch):
    monkeypatch.setattr("corpus_tools.logs.log_writing.VERSION", 2)
    write_log(driving, tmp_path / "a.mcap", name="", metadata={})
    with pytest.raises(FormatError, match="the format's version is 2, this program reads 1"):
        read_log(tmp_path / "a.mcap")
