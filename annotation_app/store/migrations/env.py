"""Runs migrations on the connection that :func:`annotation_app.store.schema.migrate` gives."""

from alembic import context

from annotation_app.store.models import Base

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Base.metadata,
    render_as_batch=True,
)
with context.begin_transaction():
    context.run_migrations()
