"""The table of other programs' tokens."""

from __future__ import annotations

from sqlalchemy.orm import Mapped, mapped_column

from annotation_app.store.models import Base


class ApiToken(Base):
    """A program's token to read what people with a login may read. It changes nothing.

    Only its digest is kept. It belongs to the installation, not to its maker.
    """

    __tablename__ = "api_token"

    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    """Name of the program in the audit trail."""
    digest: Mapped[str] = mapped_column(unique=True)
    made_by: Mapped[str]
    made_at: Mapped[float]
    expires_at: Mapped[float]
    used_at: Mapped[float | None]
    """Time of the last use, to the hour."""
