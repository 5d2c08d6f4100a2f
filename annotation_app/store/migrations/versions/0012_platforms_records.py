"""Platforms' states of assignments; their lists show earlier payments, not the ledger."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.add_column("participation", sa.Column("standing", sa.String(length=20), nullable=True))
    with op.batch_alter_table("ledger", schema=None) as batch_op:
        batch_op.drop_column("listed_before")
