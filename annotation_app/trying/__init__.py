"""Trying a command: what its clauses mean, the plan, and a video of it being carried out.

:mod:`attempt` works in a process of its own, :mod:`queue` gives it one attempt after the other,
:mod:`pages` shows what is in an attempt's folder.
"""
