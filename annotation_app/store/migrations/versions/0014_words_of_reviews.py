"""One word for each act of a reviewer: exclude, redo, restore."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None

WORDS = {"sent back": "had redone", "taken back": "restored"}


def upgrade() -> None:
    """Bring the tables up to date."""
    remark = sa.table("remark", sa.column("kind"))
    for old, new in WORDS.items():
        op.execute(remark.update().where(remark.c.kind == old).values(kind=new))
