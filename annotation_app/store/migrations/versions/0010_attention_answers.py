"""The kind of answers to attention checks has a name of its own: Check is a task."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    answer = sa.table("answer", sa.column("kind"))
    op.execute(answer.update().where(answer.c.kind == "check").values(kind="attention"))
