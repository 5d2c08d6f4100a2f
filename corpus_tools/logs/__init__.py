"""Logs of events in a world: MCAP files with the full state.

Start with :mod:`corpus_tools.logs.log_writing`, which maps content to channels, and
:mod:`corpus_tools.logs.log_reading`, which gives it back; ``docs/logs.md`` is for users.
"""
