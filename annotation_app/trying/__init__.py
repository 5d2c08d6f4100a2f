"""Trying a command: the meanings of its clauses, the plan, and a video of its execution.

:mod:`attempt` works in a process of its own, :mod:`queue` gives it one attempt after the other,
:mod:`pages` shows what is in an attempt's folder.
"""
