"""Where a study's file is, so that it can be changed in the browser."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.add_column("study", sa.Column("file", sa.String(length=4000), nullable=True))
