from __future__ import annotations

from tests.annotation_app.pages.conftest import chromium, context  # noqa: F401 - fixtures
