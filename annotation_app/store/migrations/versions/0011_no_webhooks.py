"""Drop the tables of webhooks."""

from __future__ import annotations

from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the tables up to date."""
    op.drop_table("webhook_message")
    op.drop_table("webhook")
