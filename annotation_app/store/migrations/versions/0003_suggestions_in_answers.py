"""Suggestions of programs to people, and their use in answers."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.add_column("handout", sa.Column("offer", sa.JSON(), nullable=True))
    op.add_column("answer", sa.Column("provenance", sa.JSON(), nullable=True))


def downgrade() -> None:
    """Give the tables the form that they had before."""
    with op.batch_alter_table("answer", schema=None) as batch_op:
        batch_op.drop_column("provenance")
    with op.batch_alter_table("handout", schema=None) as batch_op:
        batch_op.drop_column("offer")
