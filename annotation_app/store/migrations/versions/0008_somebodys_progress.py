"""Indexes by which somebody's progress is found without a look at all items."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.create_index("ix_item_author", "item", ["author_id"])
    for name, table, column, condition in (
        ("ix_item_attention", "item", "study_id", ("attention IS 1", "attention IS true")),
        ("ix_handout_skipped", "handout", "person_id", ("skipped_at IS NOT NULL",) * 2),
    ):
        sqlite, postgresql = map(sa.text, condition)
        op.create_index(name, table, [column], sqlite_where=sqlite, postgresql_where=postgresql)
