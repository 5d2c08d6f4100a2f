"""Counts of answers for the dashboard, beside them and in indexes."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.add_column(
        "answer", sa.Column("study_id", sa.String(length=200), server_default="", nullable=False)
    )
    op.add_column(
        "answer", sa.Column("kind", sa.String(length=20), server_default="usual", nullable=False)
    )
    op.add_column("answer", sa.Column("gist", sa.String(length=1000), nullable=True))
    op.add_column("answer", sa.Column("odd_below_s", sa.Double(), nullable=True))
    _fill()
    for name, columns in (
        ("people", ("person_id", "task", "gist", "kind", "seconds")),
        ("times", ("task", "kind", "excluded", "at")),
        ("seconds", ("task", "excluded", "seconds")),
        ("items", ("task", "kind", "excluded", "item_id", "gist")),
        ("gists", ("task", "gist", "adopted", "kind", "excluded", "surplus")),
    ):
        op.create_index(f"ix_answer_{name}", "answer", ["study_id", *columns])
    _index_some("whole", ["study_id", "task"], "gist IS NULL")
    _index_some("odd", ["study_id"], "odd_below_s IS NULL OR seconds < odd_below_s")
    of_item = ["study_id", "attention", "task", "video", "id"]
    op.create_index("ix_item_progress", "item", of_item)


def _index_some(name: str, columns: list[str], condition: str) -> None:
    where = sa.text(condition)
    op.create_index(
        f"ix_answer_{name}", "answer", columns, sqlite_where=where, postgresql_where=where
    )


def _fill() -> None:
    """Say of the answers that are there what is said of new ones, or a little less.

    A command has at most a word for every two of its characters.
    """
    json, boolean = sa.JSON(), sa.Boolean()
    kinds: dict[str, sa.types.TypeEngine[Any]] = {"attention": boolean}
    kinds |= {"body": json, "provenance": json, "payload": json}
    answer, item, event = (
        sa.table(name, *(sa.column(c, kinds.get(c)) for c in columns.split()))
        for name, columns in (
            ("answer", "item_id event_id task body provenance study_id kind gist odd_below_s"),
            ("item", "id study_id payload attention"),
            ("event", "id name"),
        )
    )
    is_check, study_id, length = (
        sa.select(found).where(item.c.id == answer.c.item_id).scalar_subquery()
        for found in (
            item.c.attention,
            item.c.study_id,
            sa.func.coalesce(sa.func.length(item.c.payload["text"].as_string()), 0),
        )
    )
    event_name = sa.select(event.c.name).where(event.c.id == answer.c.event_id).scalar_subquery()
    watched_s, speed = (
        sa.func.coalesce(answer.c.body[key].as_float(), usual)
        for key, usual in (("watched_s", 0.0), ("speed", 1.0))
    )
    was_shown = answer.c.provenance["suggestion"].as_string() == "shown"
    watched_long = sa.case((watched_s > 2.0, 1.001 * (watched_s - 2.0) / speed), else_=0.0)
    read = sa.case((was_shown, 2.5 + 0.25 * length), else_=0.0)
    rating = sa.literal('{"rating": ') + answer.c.body["rating"].as_string() + "}"
    op.execute(
        answer.update().values(
            study_id=study_id,
            kind=sa.case(
                (is_check, "check"), (event_name == "adjudicate", "adjudicated"), else_="usual"
            ),
            gist=sa.case((answer.c.task == "rate", rating)),
            odd_below_s=watched_long + read + 0.001,
        )
    )
