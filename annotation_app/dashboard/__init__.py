"""What the people who run a study see: progress, agreement, whom to look at, what to decide.

:mod:`~annotation_app.dashboard.statistics`, :mod:`~annotation_app.dashboard.consensus` and
:mod:`~annotation_app.dashboard.workers` compute it; :mod:`~annotation_app.dashboard.queue`
adjudicates; :mod:`~annotation_app.dashboard.pages` and
:mod:`~annotation_app.dashboard.interface` show it to people and to programs.
"""
