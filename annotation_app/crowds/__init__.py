"""Crowd platforms: how their workers come in, go back, and are paid.

:mod:`~annotation_app.crowds.registry` lists the providers,
:mod:`~annotation_app.crowds.platform` tells what one does.
:mod:`~annotation_app.crowds.participation` counts what was *received* here,
:mod:`~annotation_app.crowds.reconciliation` holds that against what the platform has, and
:mod:`~annotation_app.crowds.settlement` approves, rejects and pays.
"""
