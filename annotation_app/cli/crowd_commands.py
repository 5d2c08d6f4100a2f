"""``ct crowd``: studies at crowd platforms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from annotation_app.cli.installation_commands import INSTALLATION
from annotation_app.crowds.crowd_registry import Provider, providers
from corpus_tools.options import FORMAT, tell

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from annotation_app.crowds.comparison import Deed
    from annotation_app.crowds.ledger import Entry
    from annotation_app.crowds.reconciliation import Finding

SANDBOX = click.option(
    "--sandbox", is_flag=True, help="Use the platform's test mode, in which no money is paid."
)
ABOUT_WORKERS = (
    click.option(
        "--min-approved",
        type=click.IntRange(0, 100_000),
        default=0,
        metavar="N",
        help="Only for workers with that many approved assignments.",
    ),
    click.option(
        "--min-approval",
        type=click.IntRange(0, 100),
        default=0,
        metavar="PERCENT",
        help="Only for workers with that share of approved assignments.",
    ),
    click.option(
        "--minutes",
        type=click.IntRange(1, 600),
        default=15,
        show_default=True,
        help="How long an assignment takes.",
    ),
)
PUBLISH_AGAIN = click.option(
    "--publish-again",
    type=int,
    multiple=True,
    metavar="ID",
    help="Offer again what is in doubt: you have seen that it is not at the platform.",
)
ENDPOINT = click.option(
    "--endpoint",
    metavar="URL",
    envvar="CT_CROWD_ENDPOINT",
    help="Another address of the platform's interface, such as a stand-in for tests.",
)


@click.group()
def crowd() -> None:
    """Offer a study's work at crowd platforms, and pay for it.

    "publish" offers it, "collect" approves and pays it, and "reconcile" shows how things stand.

    \b
    Examples:
      ct crowd publish links my-study --url https://lab.example.org
      ct crowd collect mturk my-study --sandbox --dry-run
      ct crowd reconcile mturk my-study --sandbox
    """


@crowd.group()
def publish() -> None:
    """Offer a study's work at a crowd platform.

    \b
    Examples:
      ct crowd publish links my-study --url https://lab.example.org
      ct crowd publish mturk my-study --url https://lab.example.org --people 30 --sandbox
    """


@crowd.group()
def collect() -> None:
    """Fetch what workers sent in at a crowd platform, and pay.

    Work is approved or rejected first.

    \b
    Example:
      ct crowd collect mturk my-study --sandbox --dry-run
    """


@crowd.command()
@click.argument("provider_name", metavar="PROVIDER")
@click.argument("study_name", metavar="STUDY")
@SANDBOX
@ENDPOINT
@INSTALLATION
@FORMAT
def reconcile(*, provider_name: str, study_name: str, form: str, **options: Any) -> None:
    """Compare what was received here with what a crowd platform has. Nothing is paid.

    It also shows what was approved and paid in all, and which calls are in doubt: they were sent
    and no answer came. What the platform shows and the ledger doesn't have is noted as found there.
    --json lists every call.

    \b
    Examples:
      ct crowd reconcile mturk my-study --sandbox
      ct crowd reconcile prolific my-study --json
    """
    from g3.errors import FormatError

    known = {provider.name: provider for provider in providers() if provider.pays}
    if provider_name not in known:
        raise FormatError.unknown("platform", provider_name, known)
    from annotation_app.crowds.crowd_session import open_session
    from annotation_app.crowds.ledger import doubt_lines, entry_records, total_lines

    with open_session(known[provider_name], study_name, **_whereabouts(options)) as session:
        deeds, findings = session.compare()
        entries, restored = session.ledger.entries(), session.restored_line()
    record = {
        "deeds": deeds,
        "assignments": _records(findings),
        "ledger": entry_records(entries),
        "restored": restored,
    }
    shown = (*map(_deed_line, deeds), *_lines(findings), *total_lines(entries))
    tell(form, record, *filter(None, (restored,)), *shown, *doubt_lines(entries))


def _publish_command(provider: Provider) -> click.Command:
    again = "Run it again to add people: --people is how many there are to be in all."
    help_text = f"""{provider.summary}

    {provider.description} {again if provider.pays else "Run it again for more invitations."}

    \b
    Example:
      ct crowd publish {provider.name} my-study --url https://lab.example.org --people 10
    """

    @click.command(provider.name, help=help_text, short_help=provider.summary)
    @click.argument("study_name", metavar="STUDY")
    @click.option("--url", required=True, help="Address at which people reach the app.")
    @click.option(
        "--people",
        type=click.IntRange(1, 10_000),
        default=1,
        show_default=True,
        help="How many people are to take part in all.",
    )
    @click.option("--task", metavar="NAME", help="Which of the study's tasks [default: its first].")
    @click.option(
        "--items",
        type=click.IntRange(1, 1000),
        default=5,
        show_default=True,
        help="How many items an assignment asks for.",
    )
    @INSTALLATION
    @FORMAT
    def command(*, study_name: str, form: str, **options: Any) -> None:
        from annotation_app.crowds.crowd_session import open_session
        from annotation_app.crowds.publishing import publish_links, publish_posting

        with open_session(provider, study_name, **_whereabouts(options)) as session:
            if not provider.pays:
                links = list(publish_links(session, **options))
                tell(form, {"links": links}, *links)
                return
            posted = publish_posting(session, **options)
        added = f"{posted.added} assignments added, {posted.people} in all"
        tell(form, posted, added, posted.address)

    if provider.pays:
        for option in (*ABOUT_WORKERS, PUBLISH_AGAIN, SANDBOX, ENDPOINT):
            command = option(command)
    return command


def _collect_command(provider: Provider) -> click.Command:
    help_text = f"""Approve, reject and pay what workers sent in at {provider.title}.

    What was received here and sent in there is approved. Everything else is listed, and
    waits for you. You can run it again: nothing is done twice.

    A payment that was sent and not answered is in doubt: it may have been made. It is shown with
    its ID and never repeated by itself. Look at {provider.title}, then confirm it or pay it again.
    So is what was found there and not done from here: it holds payments until you have decided.

    \b
    Examples:
      ct crowd collect {provider.name} my-study --dry-run
      ct crowd collect {provider.name} my-study --confirm-paid 12 --pay-again 15
      ct crowd collect {provider.name} my-study --hold-flagged --pay-partial
      ct crowd collect {provider.name} my-study --bonus ASSIGNMENT 0.50 "For the careful comments"
    """

    @click.command(
        provider.name, help=help_text, short_help=f"What workers sent in at {provider.title}."
    )
    @click.argument("study_name", metavar="STUDY")
    @click.option("--dry-run", is_flag=True, help="Only show how things stand.")
    @click.option("--no-approve", is_flag=True, help="Approve nothing but what --approve names.")
    @click.option(
        "--approve",
        "approve",
        multiple=True,
        metavar="ASSIGNMENT",
        help="Approve this one, though not all of it was received or its worker is flagged.",
    )
    @click.option(
        "--reject", nargs=2, multiple=True, metavar="ASSIGNMENT REASON", help="Reject this one."
    )
    @click.option(
        "--bonus",
        nargs=3,
        multiple=True,
        type=(str, str, str),
        metavar="ASSIGNMENT AMOUNT REASON",
        help="Pay something on top.",
    )
    @click.option(
        "--hold-flagged", is_flag=True, help="Leave flagged workers' assignments for you to decide."
    )
    @click.option(
        "--pay-bonus",
        is_flag=True,
        help="Pay the study's bonus for approved assignments of workers who aren't flagged.",
    )
    @click.option(
        "--pay-partial",
        is_flag=True,
        help="Pay for what was received of assignments that were given up a day ago.",
    )
    @click.option(
        "--confirm-paid",
        type=int,
        multiple=True,
        metavar="ID",
        help="What is in doubt under this ID was done, as you have seen at the platform; what was "
        "found there is what would be done now.",
    )
    @click.option(
        "--pay-again",
        type=int,
        multiple=True,
        metavar="ID",
        help="What is in doubt under this ID was not done, as you have seen: do it now. What was "
        "found there was paid for something else.",
    )
    @click.option("--confirm-found", is_flag=True, help="Confirm all that was found there at once.")
    @click.option(
        "--confirm-restored",
        is_flag=True,
        help="The database was restored, and all payments from before that have arrived.",
    )
    @click.option(
        "--keep-unknown",
        is_flag=True,
        help="Keep the answers of people whom the platform doesn't know.",
    )
    @INSTALLATION
    @FORMAT
    @ENDPOINT
    @SANDBOX
    def command(
        *,
        study_name: str,
        dry_run: bool,
        confirm_paid: tuple[int, ...],
        pay_again: tuple[int, ...],
        confirm_found: bool,
        confirm_restored: bool,
        form: str,
        **options: Any,
    ) -> None:
        from annotation_app.crowds.crowd_session import open_session, read_wishes
        from annotation_app.crowds.decisions import Decisions
        from annotation_app.crowds.ledger import DOUBTED, OPEN, doubt_lines, entry_records

        decisions = Decisions(confirm_paid, pay_again, confirm_found, confirm_restored)
        if dry_run and decisions != Decisions():
            raise click.UsageError("--dry-run decides nothing: leave it out.")
        with open_session(provider, study_name, **_whereabouts(options)) as session:
            wishes = read_wishes(session, **options)
            deeds = [] if dry_run else session.settle(wishes, decisions)
            findings = session.findings(session.submissions(take_in=False))
            entries, restored = session.ledger.entries(*OPEN, *DOUBTED), session.restored_line()
        doubts = [entry for entry in entries if entry.state in OPEN]
        record = {
            "deeds": deeds,
            "assignments": _records(findings),
            "in_doubt": entry_records(doubts),
            "found_there": entry_records([e for e in entries if e.state == "found there"]),
            "restored": restored,
        }
        shown = (*map(_deed_line, deeds), *_lines(findings), *doubt_lines(entries))
        tell(form, record, *filter(None, (restored,)), *shown)
        _check(provider, deeds, doubts)

    return command


def _whereabouts(options: dict[str, Any]) -> dict[str, Any]:
    """Take out of the options what says where a study and its platform are."""
    there = {name: options.pop(name) for name in ("sandbox", "endpoint") if name in options}
    return {**options.pop("place")._asdict(), **there}


def _check(provider: Provider, deeds: Sequence[Deed], doubts: Sequence[Entry]) -> None:
    """Raise an error if something failed, or is in doubt."""
    from g3.errors import CorpusError

    failed = [deed for deed in deeds if deed.problem and not deed.in_doubt]
    what, fix = [], []
    if failed:
        what.append(f"{len(failed)} of {len(deeds)} could not be done")
        fix.append("the others are done; do it again for these, or look at them there")
    if any(entry.call.what == "publish" for entry in doubts):
        what.append("whether some work was offered is in doubt")
        fix.append("publish it again: that looks first, and offers nothing twice")
    count = sum(entry.call.what != "publish" for entry in doubts)
    if count:
        what.append(f"{count} {'call is' if count == 1 else 'calls are'} in doubt")
        fix.append(
            f"look at {provider.title} in some minutes; then --confirm-paid ID if it was done, "
            "--pay-again ID if not"
        )
    if what:
        raise CorpusError("; ".join(what), where=provider.title, fix="; ".join(fix))


def _deed_line(deed: Deed) -> str:
    amount = f" {deed.amount}" if deed.amount else ""
    return f"{deed.what}{amount}: {deed.assignment} {deed.problem or deed.note}".rstrip()


def _records(findings: Sequence[Finding]) -> list[Mapping[str, object]]:
    """Return the record for programs, without platforms' ids of workers."""
    return [
        {
            "assignment": finding.assignment,
            "state": finding.state,
            "done": finding.done,
            "items": finding.items,
            "due": finding.due,
            "was_paid": finding.part == "paid",
            "platform": finding.standing,
        }
        for finding in findings
    ]


def _lines(findings: Sequence[Finding]) -> Iterator[str]:
    from collections import Counter

    from annotation_app.crowds.reconciliation import EXPLANATIONS

    for finding in findings:
        if finding.state in ("settled", "working") and not finding.due:
            continue
        due = f", {finding.due} due" if finding.due and finding.part == "unpaid" else ""
        count = f" ({finding.done} of {finding.items}{due})" if finding.items else ""
        yield f"{finding.assignment}: {finding.state}{count}"
    for state, number in sorted(Counter(finding.state for finding in findings).items()):
        yield f"{number:6} {state}: {EXPLANATIONS[state]}"
    if not findings:
        yield "there are no assignments"


for _provider in providers():
    publish.add_command(_publish_command(_provider))
    if _provider.pays:
        collect.add_command(_collect_command(_provider))
