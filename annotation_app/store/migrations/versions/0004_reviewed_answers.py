"""Answers that were left out, remarks about them, and what items are searched by."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.create_table(
        "remark",
        sa.Column("id", sa.Integer(), autoincrement=True, nullable=False),
        sa.Column("answer_id", sa.Integer(), nullable=False),
        sa.Column("person_id", sa.String(length=200), nullable=False),
        sa.Column("kind", sa.String(length=20), nullable=False),
        sa.Column("text", sa.String(length=2000), nullable=False),
        sa.Column("before", sa.JSON(), nullable=False),
        sa.Column("at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(["answer_id"], ["answer.id"]),
        sa.ForeignKeyConstraint(["person_id"], ["person.id"]),
        sa.PrimaryKeyConstraint("id"),
    )
    op.create_index("ix_remark_answer_id", "remark", ["answer_id"])
    op.add_column(
        "answer",
        sa.Column("excluded", sa.Boolean(), server_default=sa.text("false"), nullable=False),
    )
    for name, length in (("video", 200), ("command", 2000)):
        op.add_column(
            "item", sa.Column(name, sa.String(length=length), server_default="", nullable=False)
        )
    op.create_index("ix_item_video", "item", ["study_id", "video"])
    _fill()


def _fill() -> None:
    item = sa.table(
        "item", sa.column("payload", sa.JSON()), sa.column("video"), sa.column("command")
    )
    video, command = (item.c.payload[key].as_string() for key in ("video", "text"))
    op.execute(
        item.update().values(
            video=sa.func.substr(sa.func.coalesce(video, ""), 1, 200),
            command=sa.func.substr(sa.func.coalesce(command, ""), 1, 2000),
        )
    )
