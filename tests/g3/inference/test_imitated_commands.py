"""Commands of many wordings end as they ask, in worlds that the model hasn't seen."""

import pytest

from benchmarks.written_commands import HELD_OUT, SETS, by_model, followed, records_of

UNREAD = ("12", "14", *HELD_OUT, *SETS[25:])
READ = tuple(name for name in SETS if name not in UNREAD)
"""The others are clean: nobody has read which of their plans are wrong."""
EVERY = 40


@pytest.mark.slow
def test_most_commands_end_as_they_ask(widely_trained):
    records = [record for name in READ for record in records_of(name)[::EVERY]]
    plan = by_model(widely_trained)
    right = [followed(record, plan).correct for record in records]
    assert sum(right) / len(right) > 0.8
