"""``ct annotate people`` and ``audit``: who may sign in, as what, and who did what."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING, Any

import click

from annotation_app.cli.installation_commands import (
    INSTALLATION,
    Place,
    changing,
    existing,
)
from corpus_tools.options import FORMAT, tell

if TYPE_CHECKING:
    from annotation_app.store.models import AuditEntry, Role
    from annotation_app.work.assigning import Way


from typing import TYPE_CHECKING

from corpus_tools.runtime.terminal import note

if TYPE_CHECKING:
    from annotation_app.core.config import Config
    from annotation_app.privacy.erasure import Traces

NOTHING = "nothing like this was noted"
LOGIN = click.argument("login", metavar="LOGIN")
ROLE = click.option(
    "--role",
    type=click.Choice(["annotator", "adjudicator", "admin"]),
    required=True,
    help="What they may do: annotators do tasks that need a login, adjudicators also decide "
    "disputes and export, admins also manage logins.",
)
URL = click.option(
    "--url",
    default="http://localhost:8765",
    show_default=True,
    metavar="URL",
    help="Where people reach the app; links begin with it.",
)
DAYS = click.option(
    "--days",
    type=click.IntRange(1, 60),
    default=7,
    show_default=True,
    help="How long the link works.",
)


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
        lines = _trace_lines(traces)
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
    lines = ["erased:", *_trace_lines(done.traces), advice]
    if not done.is_compacted:
        lines.append(
            "Others are at work, so that the database's files still hold it. It goes from them at "
            "the next start of `ct annotate`, or by `ct annotate people erase --expired`."
        )
    tell(form, record, *lines)


def _trace_lines(traces: Traces) -> list[str]:
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


@click.group()
def people() -> None:
    """Manage the people who sign in, and erase anybody's data.

    \b
    Examples:
      ct annotate people invite --role annotator
      ct annotate people list
      ct annotate people reset maria
    """


@people.command()
@LOGIN
@ROLE
@click.option(
    "--password-file",
    type=click.File("r", encoding="utf-8"),
    metavar="FILE",
    help="Read the password from the first line of a file; - is the standard input.",
)
@click.option("--ask", is_flag=True, help="Type the password here, twice; it isn't shown.")
@URL
@DAYS
@INSTALLATION
@FORMAT
def add(
    *,
    login: str,
    role: Role,
    password_file: Any,
    ask: bool,
    url: str,
    days: int,
    place: Place,
    form: str,
) -> None:
    """Add a login. Without a password you get a link by which the person sets it, once.

    \b
    Examples:
      ct annotate people add maria --role adjudicator --url https://lab.example.org
      ct annotate people add maria --role adjudicator --ask
    """
    from annotation_app.people import account_links, accounts
    from annotation_app.store.audit import COMMAND_LINE

    if ask and password_file:
        raise click.UsageError("Give either --ask or --password-file.")
    password = password_file.readline().rstrip("\r\n") if password_file else None
    if ask:
        password = click.prompt("Password", hide_input=True, confirmation_prompt=True, err=True)
    with changing(place, login) as session:
        person = accounts.add_login(session, login, role, password, actor=COMMAND_LINE)
        if password is not None:
            record = {"login": person.login, "role": role}
            tell(form, record, f"added {person.login}, {role}")
            return
        token = account_links.password_link(session, person, days, actor=COMMAND_LINE)
        name = person.login
    told = f"added {name}, {role}; by this link they set their password:"
    _tell_link(form, url, token, days, told, login=name, role=role)


@people.command()
@ROLE
@URL
@DAYS
@INSTALLATION
@FORMAT
def invite(*, role: Role, url: str, days: int, place: Place, form: str) -> None:
    """Make a link by which somebody gets a login.

    They choose the login and the password. The link works once.

    \b
    Examples:
      ct annotate people invite --role annotator
      ct annotate people invite --role admin --url https://lab.example.org --days 2
    """
    from annotation_app.people import account_links
    from annotation_app.store.audit import COMMAND_LINE

    with changing(place) as session:
        token = account_links.invite(session, role, days, actor=COMMAND_LINE)
    told = f"by this link somebody becomes {role}:"
    _tell_link(form, url, token, days, told, role=role)


@people.command("list")
@INSTALLATION
@FORMAT
def list_(*, place: Place, form: str) -> None:
    """List everybody with a login, open invitations and groups.

    \b
    Examples:
      ct annotate people list
      ct annotate people list --json
    """
    from annotation_app.dashboard.login_admin import moment
    from annotation_app.people import account_links, accounts
    from annotation_app.people.person_names import shown_name
    from annotation_app.work import assigning

    with changing(place, is_new_fine=False) as session:
        found = accounts.accounts(session)
        links = account_links.open_invitations(session)
        of_groups = {
            name: [shown_name(one) for one in members]
            for name, members in assigning.groups(session).items()
        }
    lines = [
        f"{a.login}: {a.role}, {a.state}, last signed in {moment(a.last_signed_in)}" for a in found
    ]
    lines += [
        f"an invitation: {i.role}, by {i.made_by}, until {moment(i.expires_at)}" for i in links
    ]
    lines += [f"group {name}: {', '.join(members)}" for name, members in of_groups.items()]
    names = ("role", "made_by", "expires_at")
    invitations = [{name: getattr(link, name) for name in names} for link in links]
    tell(
        form,
        {"people": found, "invitations": invitations, "groups": of_groups},
        *(lines or ["nobody has a login yet (ct annotate people invite --role admin)"]),
    )


@people.command()
@LOGIN
@INSTALLATION
@FORMAT
def block(*, login: str, place: Place, form: str) -> None:
    """End somebody's sessions at once, and let them sign in no more.

    \b
    Example:
      ct annotate people block maria
    """
    _change(form, place, login, "block", "blocked")


@people.command()
@LOGIN
@INSTALLATION
@FORMAT
def unblock(*, login: str, place: Place, form: str) -> None:
    """Let somebody sign in again, at once.

    Waits after wrong passwords end, too.

    \b
    Example:
      ct annotate people unblock maria
    """
    _change(form, place, login, "unblock", "unblocked")


@people.command()
@LOGIN
@click.argument("role", type=click.Choice(["annotator", "adjudicator", "admin"]))
@INSTALLATION
@FORMAT
def role(*, login: str, role: Role, place: Place, form: str) -> None:
    """Give somebody another role. Their sessions end.

    \b
    Example:
      ct annotate people role maria adjudicator
    """
    _change(form, place, login, "change_role", f"now {role}", role=role)


@people.command()
@LOGIN
@URL
@DAYS
@INSTALLATION
@FORMAT
def reset(*, login: str, url: str, days: int, place: Place, form: str) -> None:
    """Replace a lost or stolen password.

    It stops working, and you get a link by which the person sets a new one.

    Their sessions end, and so does a wait after wrong passwords. It works for the last admin too.

    \b
    Example:
      ct annotate people reset maria --url https://lab.example.org
    """
    from annotation_app.people import account_links, accounts
    from annotation_app.store.audit import COMMAND_LINE

    with changing(place, login, is_new_fine=False) as session:
        person = accounts.required_login(session, login)
        accounts.reset(session, person, actor=COMMAND_LINE)
        token = account_links.password_link(session, person, days, actor=COMMAND_LINE)
        name = person.login
    told = f"by this link {name} sets a new password:"
    _tell_link(form, url, token, days, told, login=name)


@people.command()
@LOGIN
@click.option("--yes", is_flag=True, help="Don't ask.")
@INSTALLATION
@FORMAT
def remove(*, login: str, yes: bool, place: Place, form: str) -> None:
    """Take somebody's login away. What they have answered stays; see also `erase`.

    \b
    Example:
      ct annotate people remove maria --yes
    """
    if not yes:
        click.confirm(f"Remove the login {login}? This can't be undone", abort=True, err=True)
    _change(form, place, login, "remove", "removed")


@people.command()
@click.argument("name", metavar="GROUP")
@click.argument("logins", nargs=-1, metavar="[LOGIN]...")
@INSTALLATION
@FORMAT
def group(*, name: str, logins: tuple[str, ...], place: Place, form: str) -> None:
    """Make a group of people with a login, to whom items can be assigned.

    It then has exactly these members; without any it is removed.

    \b
    Examples:
      ct annotate people group "night shift" maria bob
      ct annotate people group "night shift"
    """
    from annotation_app.people import accounts
    from annotation_app.store.audit import COMMAND_LINE
    from annotation_app.work import assigning

    with changing(place, " ".join(logins), is_new_fine=False) as session:
        members = [accounts.required_login(session, login).id for login in logins]
        name = assigning.set_group(session, name, members, actor=COMMAND_LINE)
    told = f"group {name}: {', '.join(logins)}" if logins else f"group {name}: removed"
    tell(form, {"group": name, "logins": logins}, told)


@people.command()
@click.argument("study", metavar="STUDY")
@click.argument("task", metavar="TASK")
@click.option("--to", "logins", multiple=True, metavar="LOGIN", help="Somebody who gets items.")
@click.option("--group", "groups", multiple=True, metavar="GROUP", help="A group that gets items.")
@click.option(
    "--of-video", "video", default="", metavar="VIDEO", help="Only the items of this video."
)
@click.option(
    "--way",
    type=click.Choice(["share", "each", "anybody"]),
    default="share",
    show_default=True,
    help="Share items out, give each to all, or give them to anybody again.",
)
@INSTALLATION
@FORMAT
def assign(
    *,
    study: str,
    task: str,
    logins: tuple[str, ...],
    groups: tuple[str, ...],
    video: str,
    way: Way,
    place: Place,
    form: str,
) -> None:
    """Assign a task's open items to people with a login, and to groups.

    \b
    Examples:
      ct annotate people assign my-study describe --group "night shift"
      ct annotate people assign my-study describe --way anybody
    """
    from annotation_app.core.problems import Refusal
    from annotation_app.people import accounts
    from annotation_app.store.audit import COMMAND_LINE
    from annotation_app.work import assigning
    from annotation_app.work.handing_out import find_study

    with changing(place, study, is_new_fine=False) as session:
        found = find_study(session, study)
        if task not in found.config["tasks"]:
            raise Refusal(422, f"The study has no task {task}.")
        people = [accounts.required_login(session, login).id for login in logins]
        count = assigning.assign(
            session, found, task, people, groups, actor=COMMAND_LINE, way=way, video=video
        )
    told = f"{count} open item{'' if count == 1 else 's'} of {task} assigned"
    tell(form, {"study": study, "task": task, "items": count}, told)


def _change(form: str, place: Place, login: str, change: str, done: str, **more: Any) -> None:
    """Change somebody's login, and report the change."""
    from annotation_app.people import accounts
    from annotation_app.store.audit import COMMAND_LINE

    with changing(place, login, is_new_fine=False) as session:
        person = accounts.required_login(session, login)
        name = person.login
        getattr(accounts, change)(session, person, actor=COMMAND_LINE, **more)
    tell(form, {"login": name, **(more or {"done": done})}, f"{name}: {done}")


def _tell_link(form: str, url: str, token: str, days: int, what: str, **record: Any) -> None:
    from annotation_app.people.account_links import path_of

    link = f"{url.rstrip('/')}{path_of(token)}"
    tell(
        form,
        {**record, "link": link, "days": days},
        what,
        link,
        f"It works once, within {days} day{'s' if days > 1 else ''}; it is not shown again.",
    )


people.add_command(erase)


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
    from annotation_app.core.config import no_installation
    from annotation_app.store.audit import trail

    with existing(place) as session:
        if session is None:
            raise no_installation(place.instance)
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
