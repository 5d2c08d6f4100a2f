"""The tables of version 0.2.0, the first release."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = None
branch_labels = None
depends_on = None

TABLES = sa.MetaData()


def upgrade() -> None:
    """Make the tables."""
    TABLES.create_all(op.get_bind())


def _text(name: str, length: int = 200, **options: Any) -> sa.Column[str]:
    return sa.Column(name, sa.String(length), **{"nullable": False, **options})


def _number(name: str, *, default: str | None = None) -> sa.Column[int]:
    usual = None if default is None else sa.text(default)
    return sa.Column(name, sa.Integer(), nullable=False, server_default=usual)


def _time(name: str, *, nullable: bool = False, default: str | None = None) -> sa.Column[float]:
    usual = None if default is None else sa.text(default)
    return sa.Column(name, sa.Double(), nullable=nullable, server_default=usual)


def _flag(name: str, default: str | None = None) -> sa.Column[bool]:
    usual = None if default is None else sa.text(default)
    return sa.Column(name, sa.Boolean(), nullable=False, server_default=usual)


def _json(name: str, *, nullable: bool = False) -> sa.Column[Any]:
    return sa.Column(name, sa.JSON(), nullable=nullable)


def _id() -> sa.Column[str]:
    return _text("id", primary_key=True)


def _counted() -> sa.Column[int]:
    return sa.Column("id", sa.Integer(), primary_key=True, autoincrement=True)


def _of(table: str, **options: Any) -> sa.Column[Any]:
    """Return a column that refers to a row of a table."""
    key = sa.ForeignKey(f"{table}.id")
    numbered = table in ("answer", "event", "participation")
    kind: sa.types.TypeEngine[Any] = sa.Integer() if numbered else sa.String(200)
    name = options.pop("name", f"{table}_id")
    return sa.Column(name, kind, key, **{"nullable": False, **options})


def _some(name: str, *columns: str, sqlite: str, postgresql: str) -> sa.Index:
    """Return an index of the rows that meet a condition."""
    conditions = sa.text(sqlite), sa.text(postgresql)
    return sa.Index(name, *columns, sqlite_where=conditions[0], postgresql_where=conditions[1])


def _table(name: str, *parts: sa.schema.SchemaItem) -> None:
    sa.Table(name, TABLES, *parts)


_OPEN = {"sqlite": "answered IS 0", "postgresql": "answered IS false"}
_SKIPPED = "skipped_at IS NOT NULL"

_table(
    "person",
    _id(),
    _text("role", 20),
    _text("provider"),
    _text("external_hash"),
    _text("login", nullable=True),
    _text("password_hash", nullable=True),
    _json("profile"),
    _time("created_at"),
    _time("blocked_at", nullable=True),
    _number("session_number", default="1"),
    _text("code", nullable=True),
    sa.UniqueConstraint("login"),
    sa.UniqueConstraint("provider", "external_hash"),
    sa.UniqueConstraint("code", name="person_code_key"),
)
_table(
    "secret", _text("name", primary_key=True), sa.Column("value", sa.LargeBinary, nullable=False)
)
_table(
    "study",
    _id(),
    _text("name", unique=True),
    _json("config"),
    _time("created_at"),
    _time("closed_at", nullable=True),
    _text("file", 4000, nullable=True),
)
_table(
    "item",
    _id(),
    _of("study"),
    _text("task", 20),
    _text("subject", 500),
    _json("payload"),
    _time("rank"),
    _of("person", name="author_id", nullable=True),
    _flag("attention", "(false)"),
    _text("video", server_default=""),
    _text("command", 2000, server_default=""),
    sa.UniqueConstraint("study_id", "task", "subject"),
    sa.Index("ix_item_video", "study_id", "video"),
    sa.Index("ix_item_author", "author_id"),
    _some("ix_item_attention", "study_id", sqlite="attention IS 1", postgresql="attention IS true"),
)
_table(
    "media",
    _id(),
    _of("study"),
    _text("video"),
    _text("role"),
    _text("path", 4000),
    _text("sha256"),
    sa.UniqueConstraint("study_id", "video", "role"),
)
_table(
    "participation",
    _counted(),
    _of("study"),
    _of("person"),
    _text("provider"),
    _text("assignment"),
    _text("task", 20),
    _number("items"),
    _text("code", nullable=True),
    _time("begun_at"),
    _time("received_at", nullable=True),
    _time("confirmed_at", nullable=True),
    _json("outcome"),
    sa.UniqueConstraint("provider", "assignment"),
)
_table(
    "draft",
    _of("item", primary_key=True),
    _of("person", primary_key=True),
    _number("revision"),
    _json("body"),
    _time("at"),
)
_table(
    "event",
    _counted(),
    _text("uuid"),
    _of("item", index=True),
    _of("person"),
    _text("name", 20),
    _json("body"),
    _time("at"),
    sa.UniqueConstraint("person_id", "uuid"),
)
_table(
    "handout",
    _of("item", primary_key=True),
    _of("person", primary_key=True),
    _time("at"),
    _time("skipped_at", nullable=True),
    _text("boot", nullable=True),
    _time("since_boot_s", nullable=True),
    _json("offer", nullable=True),
    _some("ix_handout_skipped", "person_id", sqlite=_SKIPPED, postgresql=_SKIPPED),
)
_table(
    "slot",
    _counted(),
    _of("item"),
    _of("person", nullable=True),
    _time("expires_at", nullable=True),
    _flag("answered", "(false)"),
    _text("queue", server_default=""),
    _time("rank", default="0"),
    _time("lot", default="0"),
    sa.CheckConstraint("(person_id IS NULL) = (expires_at IS NULL)", name="leased_until"),
    sa.UniqueConstraint("item_id", "person_id"),
    sa.Index("ix_slot_free", "item_id", "answered", "expires_at"),
    sa.Index("ix_slot_person", "person_id", "queue"),
    _some("ix_slot_rank", "queue", "rank", "item_id", **_OPEN),
    _some("ix_slot_lot", "queue", "lot", **_OPEN),
)
_table(
    "answer",
    _counted(),
    _of("item"),
    _of("person"),
    _text("task", 20),
    _text("subject", 500),
    _of("event", unique=True),
    _json("body"),
    _flag("surplus"),
    _flag("adopted", "(false)"),
    _time("seconds", nullable=True),
    _time("at"),
    _json("provenance", nullable=True),
    _flag("excluded", "false"),
    sa.UniqueConstraint("item_id", "person_id"),
    sa.UniqueConstraint("person_id", "task", "subject"),
)
_table(
    "remark",
    _counted(),
    _of("answer", index=True),
    _of("person"),
    _text("kind", 20),
    _text("text", 2000),
    _json("before"),
    _time("at"),
)
_table(
    "audit",
    _counted(),
    sa.Column("at", sa.Double(), nullable=False, index=True),
    _text("actor"),
    _text("action", 40),
    _text("about"),
    _json("details"),
)
_table("erasure", _text("person_id", primary_key=True), _time("at"))
_table("failed_sign_in", _text("whose", primary_key=True), _number("count"), _time("last_at"))
_table(
    "account_link",
    _text("digest", primary_key=True),
    _text("purpose", 20),
    _text("role", 20, nullable=True),
    _of("person", nullable=True),
    _text("made_by"),
    _time("made_at"),
    _time("expires_at"),
)
_table(
    "ledger",
    _counted(),
    _of("study", index=True),
    _of("participation", nullable=True),
    _text("provider"),
    _text("what", 20),
    _text("key", 500),
    _text("assignment"),
    _text("amount"),
    sa.Column("listed_before", sa.Integer()),
    _text("reason", 2000),
    _text("reference", nullable=True),
    _text("state", 20),
    _time("attempted_at"),
    _time("ended_at", nullable=True),
    _text("problem", 2000),
    sa.UniqueConstraint("provider", "what", "key"),
)
_table(
    "api_token",
    _id(),
    _text("name", unique=True),
    _text("digest", unique=True),
    _text("made_by"),
    _time("made_at"),
    _time("expires_at"),
    _time("used_at", nullable=True),
)
_table(
    "webhook",
    _id(),
    _of("study", index=True),
    _text("url", 2000),
    _text("links_to", 2000),
    _flag("with_answers"),
    _flag("allows_private"),
    _text("made_by"),
    _time("made_at"),
)
_table(
    "webhook_message",
    _id(),
    _of("webhook", index=True),
    _of("item"),
    sa.Column("answer_id", sa.Integer()),
    _text("about", 20),
    _time("made_at"),
    _text("state", 20),
    _number("attempts", default="0"),
    _time("next_at"),
    _time("ended_at", nullable=True),
    _text("problem", 500, server_default=""),
    sa.Index("ix_webhook_message_due", "state", "next_at"),
)
