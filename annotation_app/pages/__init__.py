"""The pages that people see; what they do there goes through :mod:`annotation_app.web.api`."""

from __future__ import annotations

from flask import Blueprint

from annotation_app.pages import account, entrance
from annotation_app.pages import task_pages as tasks

BLUEPRINTS: tuple[Blueprint, ...] = (
    account.blueprint,
    entrance.blueprint,
    tasks.blueprint,
)
"""All of them; :mod:`annotation_app.serving.factory` puts them into the app."""
