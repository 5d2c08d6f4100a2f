"""Crowd platforms: how their workers come in, go back, and are paid.

:mod:`~annotation_app.crowds.crowd_registry` lists the providers,
:mod:`~annotation_app.crowds.platform` says what one does.
:mod:`~annotation_app.crowds.participation` counts what was *received* here,
:mod:`~annotation_app.crowds.reconciliation` compares that with what the platform has.
:mod:`~annotation_app.crowds.publishing` offers work and
:mod:`~annotation_app.crowds.settlement` approves, rejects and pays: each call is in the
:mod:`~annotation_app.crowds.ledger` before it is made.
:mod:`~annotation_app.crowds.comparison` holds the platform's record against the ledger before that,
and :mod:`~annotation_app.crowds.decisions` does what somebody decides about the rest.
"""
