"""``ct annotate tokens`` and ``webhooks``: other programs read, and are notified."""

from __future__ import annotations

import click

from annotation_app.cli.installation_commands import INSTALLATION, Place, changing
from corpus_tools.options.format_option import FORMAT, tell

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


@click.group()
def webhooks() -> None:
    """Inform other programs of finished items.

    Nothing is sent unless you add a webhook.

    \b
    Examples:
      ct annotate webhooks add my-study https://lab.example.org/hook
      ct annotate webhooks list
    """


@webhooks.command()
@click.argument("study_name", metavar="STUDY")
@click.argument("address", metavar="URL")
@click.option(
    "--url",
    default="http://localhost:8765",
    show_default=True,
    metavar="URL",
    help="Where people reach the app; links in messages begin with it.",
)
@click.option("--with-answers", is_flag=True, help="Send what people answered, too.")
@click.option(
    "--allow-private",
    is_flag=True,
    help="The address may be this machine or in a private network, and without TLS.",
)
@INSTALLATION
@FORMAT
def add(
    *,
    study_name: str,
    address: str,
    url: str,
    with_answers: bool,
    allow_private: bool,
    place: Place,
    form: str,
) -> None:
    """Send a message to a URL for each item that is finished from now on.

    You get a secret, with which the receiver can check the messages. Messages have the
    study, the item, its task, what became of it, and a link.

    \b
    Examples:
      ct annotate webhooks add my-study https://lab.example.org/hook --url https://study.example.org
      ct annotate webhooks add my-study http://localhost:9000/ --allow-private
    """
    from annotation_app.core.config import open_instance
    from annotation_app.store.audit import COMMAND_LINE
    from annotation_app.work.handing_out import find_study
    from annotation_app.work.webhooks import add_webhook, check_webhook, written_secret

    with changing(place, address, is_new_fine=False) as session:
        study = find_study(session, study_name)
        check_webhook(address, links_to=url, allows_private=allow_private)
        made = add_webhook(
            session,
            study,
            address,
            links_to=url,
            with_answers=with_answers,
            allows_private=allow_private,
            actor=COMMAND_LINE,
        )
        name = made.id
    secret = written_secret(open_instance(*place).secret_key, name)
    tell(
        form,
        {"webhook": name, "study": study_name, "url": address, "secret": secret},
        f"webhook {name} of {study_name}; its secret:",
        secret,
        "It is not shown again.",
    )


@webhooks.command("list")
@INSTALLATION
@FORMAT
def list_webhooks(*, place: Place, form: str) -> None:
    """List webhooks, and how many messages wait.

    \b
    Examples:
      ct annotate webhooks list
      ct annotate webhooks list --json
    """
    from annotation_app.work.webhooks import webhook_states

    with changing(place, is_new_fine=False) as session:
        found = webhook_states(session)
    lines = [
        f"{one.webhook}: {one.study} to {one.url}; {one.sent} sent, {one.waiting} waiting, "
        f"{one.given_up} given up{f' (last problem: {one.problem})' if one.problem else ''}"
        for one in found
    ]
    tell(form, {"webhooks": found}, *(lines or ["there are no webhooks"]))


@webhooks.command()
@click.argument("webhook", metavar="ID")
@INSTALLATION
@FORMAT
def remove(*, webhook: str, place: Place, form: str) -> None:
    """Remove a webhook, and drop the messages that wait for it.

    \b
    Example:
      ct annotate webhooks remove 3f9a1c
    """
    from annotation_app.store.audit import COMMAND_LINE
    from annotation_app.work.webhooks import remove_webhook

    with changing(place, webhook, is_new_fine=False) as session:
        remove_webhook(session, webhook, actor=COMMAND_LINE)
    tell(form, {"webhook": webhook, "done": "removed"}, f"{webhook}: removed")


@webhooks.command()
@click.option("--again", is_flag=True, help="Also what waits for later, or was given up.")
@INSTALLATION
@FORMAT
def send(*, again: bool, place: Place, form: str) -> None:
    """Send the messages that wait. `ct annotate` does so in the background.

    Use it with another server, or when the receiver is reachable again.

    \b
    Examples:
      ct annotate webhooks send
      ct annotate webhooks send --again
    """
    from annotation_app.core.config import open_instance
    from annotation_app.serving import server as serving
    from annotation_app.serving.webhook_delivery import deliver_due
    from annotation_app.store.database import opened, transaction
    from annotation_app.store.installation import now
    from annotation_app.work.webhooks import try_again

    config = open_instance(*place)
    serving.prepare(config)
    with opened(config.database) as engine:
        at = now()
        if again:
            with transaction(engine) as session:
                try_again(session, now=at)
        done = deliver_due(engine, config.secret_key, now=at)
    tell(form, done, f"{done.sent} sent, {done.failed} failed, {done.given_up} given up")
