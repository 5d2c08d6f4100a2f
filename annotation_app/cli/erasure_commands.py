"""``ct annotate people erase``: a person's data, or all that a study's retention has ended for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from annotation_app.cli.installation_commands import INSTALLATION, Place
from corpus_tools.options import FORMAT, tell
from corpus_tools.runtime.terminal import note

if TYPE_CHECKING:
    from annotation_app.core.config import Config
    from annotation_app.privacy.erasure import Traces


@click.command()
@click.argument("who", metavar="[SUBJECT|CODE]", required=False)
@click.option(
    "--platform",
    metavar="NAME",
    help="Take SUBJECT for a worker's id at this platform, such as prolific.",
)
@click.option("--expired", is_flag=True, help="Erase what retention_days of studies are over for.")
@click.option(
    "--study",
    "study_name",
    metavar="NAME",
    help="With --expired, only this study.",
)
@click.option("--dry-run", is_flag=True, help="Only show what would be erased.")
@click.option("--yes", is_flag=True, help="Don't ask before erasing.")
@INSTALLATION
@FORMAT
def erase(
    *,
    who: str | None,
    platform: str | None,
    expired: bool,
    study_name: str | None,
    dry_run: bool,
    yes: bool,
    place: Place,
    form: str,
) -> None:
    """Erase a person's data, and what was made of their words.

    SUBJECT is what exports call them, CODE what their pages show them; a login will do too. What
    was made of their words goes as well, with other people's answers to it. Payments stay in the
    books. It is noted in the audit trail, and in the instance's erased.jsonl, by which
    `ct annotate restore` erases them from older backups.

    \b
    Examples:
      ct annotate people erase 7KQM-2XWD-HN5R --dry-run
      ct annotate people erase 1f0c9a77b3e2
      ct annotate people erase 5f1c0a --platform prolific --yes
      ct annotate people erase --expired
    """
    from annotation_app.core.config import existing_instance

    if expired == (who is not None) or (study_name and not expired) or (platform and expired):
        raise click.UsageError(
            "name one person, with --platform if you like, or give --expired, with --study"
        )
    config = existing_instance(*place)
    if who is None:
        _erase_expired(config, study_name, dry_run=dry_run, form=form)
    else:
        _erase_person(config, who, platform, dry_run=dry_run, yes=yes, form=form)


def _erase_person(
    config: Config, who: str, platform: str | None, *, dry_run: bool, yes: bool, form: str
) -> None:
    import sys
    import time

    from annotation_app.privacy import erasure
    from annotation_app.store.database import opened
    from g3.errors import FormatError

    with opened(config.database) as engine:
        traces = erasure.preview(engine, config, who, platform)
        lines = _lines(traces)
        if dry_run:
            record = {**traces.counts(), "erased": False}
            tell(form, record, *lines, "nothing was erased: this was a dry run")
            return
        if not yes:
            if not sys.stdin.isatty():
                raise FormatError(
                    "there is no terminal to ask whether to erase this",
                    fix="give --yes, after a look with --dry-run",
                )
            note(*lines)
            click.confirm("Erase it? This can't be undone.", abort=True, err=True)
        done = erasure.erase_person(engine, config, traces.person_id, now=time.time())
    record = {**done.traces.counts(), "erased": True, "compacted": done.is_compacted}
    advice = f"Keep a copy of {done.tombstones} outside this machine, as you keep backups."
    lines = ["erased:", *_lines(done.traces), advice]
    if not done.is_compacted:
        lines.append(
            "Others are at work, so that the database's files still hold it. It goes from them at "
            "the next start of `ct annotate`, or by `ct annotate people erase --expired`."
        )
    tell(form, record, *lines)


def _lines(traces: Traces) -> list[str]:
    counts = traces.counts()
    lines = [f"{count:6} {name.replace('_', ' ')}" for name, count in counts.items()]
    if traces.unpaid:
        lines.append(
            f"{traces.unpaid} of these assignments were sent in and have no payment in the books. "
            "Pay first with `ct crowd collect`: afterwards nobody knows what for."
        )
    return lines


def _erase_expired(config: Config, study_name: str | None, *, dry_run: bool, form: str) -> None:
    import time

    from annotation_app.privacy.retention import expire
    from annotation_app.store.database import opened
    from annotation_app.store.schema import check_current

    with opened(config.database) as engine:
        check_current(engine)
        done = expire(engine, now=time.time(), study=study_name, dry_run=dry_run)
    lines = [
        f"study {one.study}: {'would unlink' if dry_run else 'unlinked'} its answers from "
        f"{one.people} people; {one.profiles} profiles, {one.drafts} drafts, "
        f"{one.assignments} assignments erased; {one.payments_unlinked} payments unlinked"
        for one in done
    ]
    record = {"studies": done, "erased": not dry_run and bool(done)}
    tell(form, record, *(lines or ["nothing is due to be erased"]))
