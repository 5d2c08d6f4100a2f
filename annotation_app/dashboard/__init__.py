"""What the people who run a study see: progress, agreement, whom to look at, what to decide.

:mod:`~annotation_app.dashboard.study_statistics`, :mod:`~annotation_app.dashboard.consensus` and
:mod:`~annotation_app.dashboard.workers` compute it;
:mod:`~annotation_app.dashboard.adjudication_queue` adjudicates;
:mod:`~annotation_app.dashboard.dashboard_pages` and
:mod:`~annotation_app.dashboard.dashboard_api` show it to people and to programs.
"""
