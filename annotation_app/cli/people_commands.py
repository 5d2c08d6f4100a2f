"""``ct annotate people``: who may sign in, as what, and whose data are kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from annotation_app.cli.changing_commands import changing, moment
from annotation_app.cli.command_options import INSTALLATION, Place
from annotation_app.cli.erasure_commands import erase
from corpus_tools.options.format_option import FORMAT, tell

if TYPE_CHECKING:
    from annotation_app.store.models import Role

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
    _tell_link(form, _link(url, token), days, told, login=name, role=role)


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
    _tell_link(form, _link(url, token), days, told, role=role)


@people.command("list")
@INSTALLATION
@FORMAT
def list_(*, place: Place, form: str) -> None:
    """List everybody with a login, and open invitations.

    \b
    Examples:
      ct annotate people list
      ct annotate people list --json
    """
    from annotation_app.people import account_links, accounts

    with changing(place, is_new_fine=False) as session:
        found = accounts.accounts(session)
        links = account_links.open_invitations(session)
        invitations = [
            {"role": link.role, "made_by": link.made_by, "expires_at": link.expires_at}
            for link in links
        ]
    lines = [
        f"{a.login}: {a.role}, {a.state}, last signed in {moment(a.last_signed_in)}" for a in found
    ]
    lines += [
        f"an invitation: {i['role']}, by {i['made_by']}, until {moment(i['expires_at'])}"
        for i in invitations
    ]
    tell(
        form,
        {"people": found, "invitations": invitations},
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
    from annotation_app.people import accounts

    name = _change(login, place, accounts.block)
    tell(form, {"login": name, "done": "blocked"}, f"{name}: blocked")


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
    from annotation_app.people import accounts

    name = _change(login, place, accounts.unblock)
    tell(form, {"login": name, "done": "unblocked"}, f"{name}: unblocked")


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
    from annotation_app.people import accounts

    name = _change(login, place, accounts.change_role, role=role)
    tell(form, {"login": name, "role": role}, f"{name}: now {role}")


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
    _tell_link(form, _link(url, token), days, told, login=name)


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
    from annotation_app.people import accounts

    if not yes:
        click.confirm(f"Remove the login {login}? This can't be undone", abort=True, err=True)
    name = _change(login, place, accounts.remove)
    tell(form, {"login": name, "done": "removed"}, f"{name}: removed")


def _change(login: str, place: Place, change: Any, **more: Any) -> str:
    """Change somebody's login; the login as it is kept."""
    from annotation_app.people import accounts
    from annotation_app.store.audit import COMMAND_LINE

    with changing(place, login, is_new_fine=False) as session:
        person = accounts.required_login(session, login)
        name = str(person.login)
        change(session, person, actor=COMMAND_LINE, **more)
    return name


def _tell_link(form: str, link: str, days: int, what: str, **record: Any) -> None:
    tell(
        form,
        {**record, "link": link, "days": days},
        what,
        link,
        f"It works once, within {days} day{'s' if days > 1 else ''}; it is not shown again.",
    )


def _link(url: str, token: str) -> str:
    from annotation_app.people.account_links import path_of

    return f"{url.rstrip('/')}{path_of(token)}"


people.add_command(erase)
