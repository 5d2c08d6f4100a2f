"""Trying a command: the meanings of its clauses, the plan, and a video of its execution.

:mod:`attempt` works in two processes of its own, which plan and film, :mod:`attempt_queue` gives
them one attempt after the other, :mod:`try_pages` shows what is in an attempt's folder.
"""
