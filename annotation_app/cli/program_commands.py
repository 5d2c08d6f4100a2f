"""``ct annotate tokens``: let other programs read."""

from __future__ import annotations

import click

from annotation_app.cli.installation_commands import INSTALLATION, Place, changing
from corpus_tools.options import FORMAT, tell

NAME = click.argument("name", metavar="NAME")


@click.group()
def tokens() -> None:
    """Let programs read numbers and answers, by tokens.

    A token reads what adjudicators read, of all studies, and changes nothing.

    \b
    Examples:
      ct annotate tokens make nightly-report
      ct annotate tokens list
      ct annotate tokens revoke nightly-report
    """


@tokens.command()
@NAME
@click.option(
    "--days",
    type=click.IntRange(1, 3650),
    default=365,
    show_default=True,
    help="How long the token works.",
)
@INSTALLATION
@FORMAT
def make(*, name: str, days: int, place: Place, form: str) -> None:
    """Make a token. It is shown once.

    Programs send it as "Authorization: Bearer TOKEN". NAME is what lists and the audit trail
    call the program.

    \b
    Examples:
      ct annotate tokens make nightly-report
      ct annotate tokens make notebook --days 30
    """
    from annotation_app.people.api_tokens import make_token
    from annotation_app.store.audit import COMMAND_LINE

    with changing(place, name) as session:
        token = make_token(session, name, days, actor=COMMAND_LINE)
    tell(
        form,
        {"name": name, "days": days, "token": token},
        f"the token of {name}:",
        token,
        f"It works for {days} day{'s' if days > 1 else ''}; it is not shown again.",
    )


@tokens.command("list")
@INSTALLATION
@FORMAT
def list_tokens(*, place: Place, form: str) -> None:
    """List tokens: who made them, and when they were used last.

    \b
    Examples:
      ct annotate tokens list
      ct annotate tokens list --json
    """
    from annotation_app.dashboard.login_admin import moment
    from annotation_app.people.api_tokens import tokens

    with changing(place, is_new_fine=False) as session:
        found = tokens(session)
    names = ("name", "made_by", "made_at", "expires_at", "used_at")
    records = [{name: getattr(one, name) for name in names} for one in found]
    lines = [
        f"{one.name}: by {one.made_by}, until {moment(one.expires_at)}, "
        f"last used {moment(one.used_at)}"
        for one in found
    ]
    tell(form, {"tokens": records}, *(lines or ["there are no tokens (ct annotate tokens make)"]))


@tokens.command()
@NAME
@INSTALLATION
@FORMAT
def revoke(*, name: str, place: Place, form: str) -> None:
    """Stop a token from working.

    \b
    Example:
      ct annotate tokens revoke nightly-report
    """
    from annotation_app.people.api_tokens import revoke_token
    from annotation_app.store.audit import COMMAND_LINE

    with changing(place, name, is_new_fine=False) as session:
        revoke_token(session, name, actor=COMMAND_LINE)
    tell(form, {"name": name, "done": "revoked"}, f"{name}: revoked")
