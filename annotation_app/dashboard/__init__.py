"""Pages for the people who run a study: progress, agreement, workers to check, decisions to make.

:mod:`~annotation_app.dashboard.study_statistics`, :mod:`~annotation_app.dashboard.consensus` and
:mod:`~annotation_app.dashboard.workers` compute it;
:mod:`~annotation_app.dashboard.adjudication_queue` adjudicates;
:mod:`~annotation_app.dashboard.dashboard_pages` and
:mod:`~annotation_app.dashboard.dashboard_api` show it to people and to programs.
"""
