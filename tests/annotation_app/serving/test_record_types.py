from __future__ import annotations

from annotation_app.serving.factory import record_types
from corpus_tools.logs.channels import CHANNELS


def test_what_is_read_of_a_log_is_known_before_there_are_threads() -> None:
    """A server died where two requests were the first to read a log at the same time."""
    assert {channel.message for channel in CHANNELS.values()} <= set(record_types())
