"""``ct annotate audit``: who did what."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING

import click

from annotation_app.cli.command_options import INSTALLATION, Place, no_installation
from annotation_app.cli.study_commands import existing
from corpus_tools.options.format_option import FORMAT, tell

if TYPE_CHECKING:
    from annotation_app.store.models import AuditEntry

NOTHING = "nothing like this was noted"


@click.command()
@click.option("--person", default="", metavar="NAME", help="Only of this login, study or subject.")
@click.option("--action", default="", help='Only this, such as "signed in" or "exported".')
@click.option(
    "--most", type=click.IntRange(1), default=100, show_default=True, help="How many entries."
)
@INSTALLATION
@FORMAT
def audit(*, person: str, action: str, most: int, place: Place, form: str) -> None:
    """List what people with a login did, and when, newest first.

    Signing in, exporting, paying, blocking and erasing are listed, for example.

    \b
    Examples:
      ct annotate audit
      ct annotate audit --person maria --action "signed in" --json
    """
    from annotation_app.store.audit import trail

    with existing(place) as session:
        if session is None:
            raise no_installation(place)
        entries = trail(session, person=person, action=action, most=most)
    records = [
        {name: getattr(entry, name) for name in ("id", "at", "actor", "action", "about", "details")}
        for entry in entries
    ]
    tell(form, {"entries": records}, *(map(_line, entries) if entries else [NOTHING]))


def _line(entry: AuditEntry) -> str:
    at = datetime.datetime.fromtimestamp(entry.at, datetime.timezone.utc)
    details = "; ".join(f"{name}: {value}" for name, value in entry.details.items())
    told = " ".join(filter(None, (entry.actor, entry.action, entry.about)))
    return f"{at:%Y-%m-%d %H:%M:%S UTC} {told}{f' ({details})' if details else ''}"
