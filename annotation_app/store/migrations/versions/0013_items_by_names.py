"""Items about videos differ by the videos' names, too, not by their files alone."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None

ABOUT_FILE = "video " + "_" * 64
"""The pattern of a subject that has the digest of a file alone."""


def upgrade() -> None:
    """Bring the tables up to date."""
    item = sa.table("item", *map(sa.column, ("id", "subject", "video")))
    answer = sa.table("answer", *map(sa.column, ("item_id", "subject")))
    video = sa.select(item.c.video).where(item.c.id == answer.c.item_id).scalar_subquery()
    op.execute(
        answer.update()
        .where(answer.c.subject.like(ABOUT_FILE))
        .values(subject=answer.c.subject + " " + video)
    )
    op.execute(
        item.update()
        .where(item.c.subject.like(ABOUT_FILE))
        .values(subject=item.c.subject + " " + item.c.video)
    )
