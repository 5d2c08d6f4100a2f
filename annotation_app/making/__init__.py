"""Making and changing studies in the browser, step by step.

What admins type is kept as a draft. The last step shows what changes, and writes the study's file.
"""

from __future__ import annotations

from flask import Blueprint

from annotation_app.making import (
    drawing_pages,
    preview_pages,
    review_pages,
    step_pages,
    upload_pages,
)

BLUEPRINTS: tuple[Blueprint, ...] = (
    step_pages.blueprint,
    review_pages.blueprint,
    preview_pages.blueprint,
    upload_pages.blueprint,
    drawing_pages.blueprint,
)
"""All of them; :mod:`annotation_app.serving.factory` puts them into the app."""
