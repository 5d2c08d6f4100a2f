"""The web app in which people type, annotate, ground, check and rate commands.

Read :mod:`~annotation_app.store.models` first: what is in the database. Then
:mod:`~annotation_app.items.assignment`, who gets which item, and
:mod:`~annotation_app.items.submissions`, how answers are kept, and
:mod:`~annotation_app.tasks.task_record`, what a task is. Pages and blueprints only call these.
"""
