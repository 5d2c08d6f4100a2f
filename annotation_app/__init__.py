"""The web app in which people type, annotate, ground, check and rate commands.

Read :mod:`~annotation_app.models` first: what is in the database. Then
:mod:`~annotation_app.assignment`, who gets which item, and
:mod:`~annotation_app.submissions`, how answers are kept. Pages and blueprints only call
these.
"""
