"""The pages that people see; what they do there goes through :mod:`annotation_app.api`."""

from __future__ import annotations

from flask import Blueprint

from annotation_app.pages import account, entrance, practice, tasks

BLUEPRINTS: tuple[Blueprint, ...] = (
    account.blueprint,
    entrance.blueprint,
    tasks.blueprint,
    practice.blueprint,
)
"""All of them; :mod:`annotation_app.factory` puts them into the app."""
