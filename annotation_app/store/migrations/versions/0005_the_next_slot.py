"""An index that leads to the next free slot, without a look at all others."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.add_column(
        "slot", sa.Column("queue", sa.String(length=200), server_default="", nullable=False)
    )
    for name in ("rank", "lot"):
        zero = sa.text("0")
        op.add_column("slot", sa.Column(name, sa.Double(), server_default=zero, nullable=False))
    _fill()
    op.drop_index("ix_item_rank", "item")
    op.drop_index("ix_slot_person_id", "slot")
    op.create_index("ix_slot_person", "slot", ["person_id", "queue"])
    sqlite, postgresql = sa.text("answered IS 0"), sa.text("answered IS false")
    for name, columns in (
        ("ix_slot_rank", ["queue", "rank", "item_id"]),
        ("ix_slot_lot", ["queue", "lot"]),
    ):
        op.create_index(name, "slot", columns, sqlite_where=sqlite, postgresql_where=postgresql)


def _fill() -> None:
    item = sa.table("item", *map(sa.column, ("id", "study_id", "task", "rank")))
    slot = sa.table("slot", *map(sa.column, ("item_id", "queue", "rank", "lot")))
    lot: sa.ColumnElement[Any] = sa.func.random()
    if op.get_bind().dialect.name == "sqlite":  # a whole number there
        lot = sa.func.abs(lot / 2) / float(2**62)
    of_item = item.c.id == slot.c.item_id
    queue = sa.select(item.c.study_id + " " + item.c.task).where(of_item).scalar_subquery()
    rank = sa.select(item.c.rank).where(of_item).scalar_subquery()
    op.execute(slot.update().values(queue=queue, rank=rank, lot=lot))
