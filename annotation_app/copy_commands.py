"""``ct annotate backup``, ``restore`` and ``copy-media``: copies of what an installation holds."""

from __future__ import annotations

from pathlib import Path

import click

from annotation_app.command_options import DATABASE, INSTANCE
from corpus_tools.format_option import FORMAT, tell


@click.command("copy-media")
@click.argument("target")
@INSTANCE
@DATABASE
@FORMAT
def copy_media(*, target: str, instance: Path, database: str | None, form: str) -> None:
    """Copy all videos and pictures to a folder or an object store.

    TARGET may be s3://bucket/prefix; a web server or a CDN can then give them out.

    Their names tell nothing. Doing it again copies what is new. Then `ct annotate serve
    --media-url` sends browsers there.

    \b
    Examples:
      ct annotate copy-media /srv/media
      ct annotate copy-media s3://my-bucket/media
    """
    from annotation_app.config import open_instance
    from annotation_app.database import opened, reading
    from annotation_app.media_copies import copy_media as copy
    from corpus_tools.progress import progress_bar

    with (
        opened(open_instance(instance, database).database) as engine,
        reading(engine) as session,
        progress_bar("copying videos and pictures") as on_progress,
    ):
        copied = copy(session, target, on_progress)
    tell(form, {"target": target, "copied": copied}, f"copied {copied} files to {target}")


@click.command()
@click.argument("archive", type=click.Path(path_type=Path, dir_okay=False))
@INSTANCE
@DATABASE
@FORMAT
def backup(*, archive: Path, instance: Path, database: str | None, form: str) -> None:
    """Write the database and the secret key to a file.

    The studies may be served meanwhile.

    \b
    Example:
      ct annotate backup annotation-backup.jsonl.gz
    """
    from annotation_app.backups import back_up
    from annotation_app.config import open_instance

    rows = back_up(open_instance(instance, database), archive)
    tell(form, {"files": [archive], "rows": rows}, f"wrote {archive}: {rows} rows")


@click.command()
@click.argument("archive", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@INSTANCE
@DATABASE
@FORMAT
def restore(*, archive: Path, instance: Path, database: str | None, form: str) -> None:
    """Fill an empty database with what a backup holds. Any kind of database will do.

    \b
    Example:
      ct annotate restore annotation-backup.jsonl.gz --instance restored
    """
    from annotation_app.backups import restore as restore_

    rows = restore_(archive, instance, database)
    tell(form, {"rows": rows}, f"restored {rows} rows")
