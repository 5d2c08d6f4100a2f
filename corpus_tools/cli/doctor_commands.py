"""``ct doctor`` and ``ct completion``: is everything there, and the shell's help with it."""

from __future__ import annotations

import click

from corpus_tools.options import FORMAT, PLAIN, tell
from corpus_tools.runtime.terminal import say


@click.command(epilog="\b\nExamples:\n  ct doctor\n  ct doctor drawing --json")
@click.argument("names", metavar="[CHECK]...", nargs=-1)
@FORMAT
@click.pass_context
def doctor(ctx: click.Context, names: tuple[str, ...], form: str) -> None:
    """Check this machine, and say how to get what is missing.

    All checks run, or those that are named. The exit status is 2 if something is missing. Extras
    that you haven't installed are a remark only, unless you name the check that needs them.
    """
    from corpus_tools.doctor.diagnosis import checks, diagnose
    from corpus_tools.runtime.text_tables import columns
    from g3.errors import CorpusError

    registered = checks()
    for name in names:
        if name not in registered:
            raise CorpusError.unknown("check", name, registered)
    chosen = {name: registered[name] for name in names} if names else registered
    findings = []
    for finding in diagnose(chosen, extras_needed=bool(names)):
        findings.append(finding)
        if form == PLAIN:
            mark, colour = ("no", "red") if not finding.ok else ("ok", "green")
            if finding.ok and finding.fix:
                mark, colour = "--", "yellow"
            about = ("", "", finding.fix) if finding.fix else ()
            first, *more = columns(
                [(mark, f"{finding.name:<10}", finding.found), *filter(None, [about])]
            )
            say(click.style(first[:2], fg=colour) + first[2:], *more, styled=True)
    tell(form, {"checks": findings})
    ctx.exit(0 if all(finding.ok for finding in findings) else 2)


@click.command(
    epilog="\b\nExamples:\n"
    '  eval "$(ct completion bash)"                                   # in ~/.bashrc\n'
    "  ct completion fish > ~/.config/fish/completions/ct.fish"
)
@click.argument("shell", type=click.Choice(["bash", "fish", "zsh"]))
def completion(shell: str) -> None:
    """Print a script that has a shell complete ct's options."""
    from click.shell_completion import BashComplete, FishComplete, ZshComplete

    from corpus_tools.cli.console import cli

    kind = {"bash": BashComplete, "fish": FishComplete, "zsh": ZshComplete}[shell]
    click.echo(kind(cli, {}, "ct", "_CT_COMPLETE").source())
