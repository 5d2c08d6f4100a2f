"""``ct annotate backup``, ``verify``, ``restore``, ``copy-media``: copies of an installation."""

from __future__ import annotations

from pathlib import Path

import click

from annotation_app.cli.installation_commands import INSTALLATION, Place
from corpus_tools.options import FORMAT, TARGET_FILE, ExistingPath, tell


@click.command("copy-media")
@click.argument("target")
@INSTALLATION
@FORMAT
def copy_media(*, target: str, place: Place, form: str) -> None:
    """Copy all videos and pictures to a folder or an object store.

    TARGET may be s3://bucket/prefix; a web server or a CDN can then give them out.

    File names say nothing about people. Run it again to copy what is new. Then `ct annotate serve
    --media-url` sends browsers there.

    \b
    Examples:
      ct annotate copy-media /srv/media
      ct annotate copy-media s3://my-bucket/media
    """
    from annotation_app.copies.media_copies import copy_media as copy
    from annotation_app.core.config import existing_instance
    from annotation_app.store.database import opened, reading
    from corpus_tools.runtime.progress import progress_bar

    with (
        opened(existing_instance(*place).database) as engine,
        reading(engine) as session,
        progress_bar("copying videos and pictures") as on_progress,
    ):
        copied = copy(session, target, on_progress)
    tell(form, {"target": target, "copied": copied}, f"copied {copied} files to {target}")


VERIFIED = "verified: all rows are there as they were written"
PASSPHRASE_FILE = click.option(
    "--passphrase-file",
    metavar="FILE",
    type=ExistingPath(dir_okay=False),
    help="File whose first line is the passphrase of the keys in the backup.",
)


@click.command()
@click.argument("archive", type=TARGET_FILE)
@click.option(
    "--without-keys",
    is_flag=True,
    help="Leave the keys out. To restore it you need the instance's file secret-key.",
)
@PASSPHRASE_FILE
@INSTALLATION
@FORMAT
def backup(
    *,
    archive: Path,
    without_keys: bool,
    passphrase_file: Path | None,
    place: Place,
    form: str,
) -> None:
    """Write the database to a file.

    The studies may be served meanwhile. The keys sign links and hide people's ids. They are
    encrypted with a passphrase, or left out with --without-keys. The passphrase is asked for unless
    there is --passphrase-file. Answers and hashes of passwords aren't encrypted.

    \b
    Examples:
      ct annotate backup annotation-backup.jsonl.gz
      ct annotate backup annotation-backup.jsonl.gz --passphrase-file /etc/g3-passphrase
      ct annotate backup annotation-backup.jsonl.gz --without-keys
    """
    from annotation_app.copies.backups import back_up
    from annotation_app.core.config import existing_instance

    if without_keys and passphrase_file is not None:
        raise click.UsageError("give --without-keys or --passphrase-file, not both")
    passphrase = None if without_keys else _passphrase(passphrase_file, str(archive), is_new=True)
    rows = back_up(existing_instance(*place), archive, passphrase)
    keys = "without the keys" if without_keys else "with the keys encrypted"
    record = {"files": [archive], "rows": rows, "keys": not without_keys}
    tell(form, record, f"wrote {archive}: {rows} rows, {keys}")


@click.command()
@click.argument("archive", type=ExistingPath(dir_okay=False))
@FORMAT
def verify(*, archive: Path, form: str) -> None:
    """Check that nothing of a backup is missing or changed.

    \b
    Example:
      ct annotate verify annotation-backup.jsonl.gz
    """
    from annotation_app.copies.restoring import verify as verify_

    contents = verify_(archive)
    counts = {table: count for table, count in contents.counts.items() if count}
    record = {"rows": contents.rows, "counts": counts, "verified": True}
    lines = [f"{count:8} {table}" for table, count in sorted(counts.items())]
    tell(form, record, f"{archive}: {contents.rows} rows", *lines, VERIFIED)


@click.command()
@click.argument("archive", type=ExistingPath(dir_okay=False))
@click.option(
    "--keys",
    metavar="FILE",
    type=ExistingPath(dir_okay=False),
    help="The file secret-key of the instance that was backed up.",
)
@PASSPHRASE_FILE
@click.option(
    "--erased",
    metavar="FILE",
    type=ExistingPath(dir_okay=False),
    help="Whose data were erased since [default: erased.jsonl beside the backup or the instance].",
)
@INSTALLATION
@FORMAT
def restore(
    *,
    archive: Path,
    keys: Path | None,
    passphrase_file: Path | None,
    erased: Path | None,
    place: Place,
    form: str,
) -> None:
    """Fill an empty database with what a backup holds.

    Any kind of database will do.

    All of the backup is checked first, and nothing is left behind if something is wrong. People
    whose data were erased since are erased again. `ct crowd` pays nobody from the restored database
    before you have confirmed that it knows all earlier payments.

    \b
    Examples:
      ct annotate restore annotation-backup.jsonl.gz --instance restored
      ct annotate restore annotation-backup.jsonl.gz --instance restored --keys secret-key
    """
    from annotation_app.copies.restoring import restore as restore_
    from annotation_app.copies.restoring import verify as verify_
    from annotation_app.store.tombstones import find_tombstones, joined, read_tombstones

    files = [erased] if erased is not None else find_tombstones(archive, place.instance)
    gone = joined(*(read_tombstones(file) for file in files)).values()
    passphrase = None
    if passphrase_file is not None or (keys is None and verify_(archive).head.keys is not None):
        passphrase = _passphrase(passphrase_file, str(archive), is_new=False)
    done = restore_(archive, *place, keys=keys, passphrase=passphrase, erased=gone)
    rows = done.contents.rows
    record = {"rows": rows, "verified": True, "erased_again": done.erased}
    lines = [f"restored {rows} rows", VERIFIED]
    if done.contents.counts.get("participation", 0):
        lines.append("payments at crowd platforms wait: the next `ct crowd` says what for")
    if files:
        names = ", ".join(map(str, files))
        lines.append(f"erased again: the data of {done.erased} of {len(gone)} people in {names}")
    tell(form, record, *lines)


def _passphrase(file: Path | None, where: str, *, is_new: bool) -> str:
    """Read a passphrase from a file, or from the terminal."""
    import sys

    from g3.errors import FormatError
    from g3.storage import regular_file
    from g3.storage.text_lines import split_lines

    if file is not None:
        lines = split_lines(regular_file.read_bytes(file).decode("utf-8", "replace"))
        if not lines or not lines[0]:
            raise FormatError("there is no passphrase", where=str(file), fix="write one there")
        return lines[0]
    if not sys.stdin.isatty():
        instead = "--without-keys" if is_new else "--keys FILE"
        raise FormatError(
            "the backup's keys need a passphrase, and there is no terminal to ask for it",
            where=where,
            fix=f"give --passphrase-file FILE, or {instead}",
        )
    prompt = "Passphrase for the keys" if is_new else "Passphrase of the keys"
    return str(click.prompt(prompt, hide_input=True, confirmation_prompt=is_new, err=True))
