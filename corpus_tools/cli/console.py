"""The console script ``ct``: finds the commands, and turns errors into one line each.

A command is a click command that an installed distribution names in the entry point
group ``ct.commands``, so other distributions can add theirs. Modules with commands
import only click at their top: ``ct --help`` loads them all.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.metadata
import io
import logging
import os
import re
import sys
import textwrap
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import click

from corpus_tools import __version__
from corpus_tools.options import TARGETS
from corpus_tools.runtime.extras import DISTRIBUTION, extra_of
from corpus_tools.runtime.terminal import VisibleFormatter, note
from g3.errors import CorpusError, ManyError
from g3.storage.system_errors import about, named_error

ENTRY_POINT_GROUP = "ct.commands"

EXIT_UNEXPECTED = 1
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130

LONGEST_MESSAGE = 2000
"""Length beyond which an error loses its middle."""
COLUMNS = 100
"""Longest line of a help text, or of a list of what there is."""
MOST_LINES = 50
"""Largest number of errors that are shown together."""


class _EntryPointGroup(click.Group):
    """A click group whose commands are entry points."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted({point.name for point in _entry_points()} | self.commands.keys())

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        try:
            return super().resolve_command(ctx, args)
        except click.NoSuchCommand as error:  # click suggests none of those that aren't loaded
            name = error.command_name
            raise click.NoSuchCommand(
                name, possibilities=self.list_commands(ctx), ctx=ctx
            ) from None

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        point = next((p for p in _entry_points() if p.name == cmd_name), None)
        if point is None:
            return super().get_command(ctx, cmd_name)
        try:
            command = point.load()
            if not isinstance(command, click.Command):
                raise TypeError(f"{point.value} is not a click command")
        except Exception as error:  # the other commands must go on working
            return _broken_command(cmd_name, point, error)
        return command


@functools.cache
def _entry_points() -> list[importlib.metadata.EntryPoint]:
    return list(importlib.metadata.entry_points(group=ENTRY_POINT_GROUP))


def _broken_command(
    name: str, point: importlib.metadata.EntryPoint, error: Exception
) -> click.Command:
    provider = point.dist.name if point.dist else "that provides it"
    reason = f"{type(error).__name__}: {error}"

    def fail() -> None:
        raise CorpusError(
            f"the command {name} can't be loaded: {reason}",
            fix=f"reinstall or remove the package {provider}",
        ) from error

    # Arguments and --help are taken as they come, so that each way to call it shows the reason.
    return click.Command(
        name,
        callback=fail,
        short_help=f"(can't be loaded: {reason})",
        add_help_option=False,
        context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
    )


@click.group(
    cls=_EntryPointGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": COLUMNS},
    epilog="\b\nExamples:\n"
    "  ct import slu-core slu_core/data --out aaai11\n"
    "  ct eval table1 --corpus aaai11 --cv scenario\n"
    "  ct help eval table1",
)
@click.version_option(__version__, "--version", "-V", prog_name="ct")
@click.option("--verbose", is_flag=True, help="Log what is done; show tracebacks of errors.")
@click.pass_context
def cli(ctx: click.Context, verbose: bool) -> None:
    """Ground natural language commands: import corpora, train the model, print the tables.

    A re-implementation of Generalized Grounding Graphs (Tellex et al., AAAI 2011).
    """
    ctx.obj["verbose"] = verbose
    if os.environ.get("NO_COLOR"):
        ctx.color = False  # click colours what goes to a terminal, whatever this says
    _set_up_logging(verbose)


@cli.command("help", epilog="\b\nExamples:\n  ct help\n  ct help eval table1")
@click.argument("words", metavar="[COMMAND]...", nargs=-1)
@click.pass_obj
def help_(options: dict[str, Any], *, words: tuple[str, ...]) -> None:
    """Show the help of a command."""
    cli.main([*words, "--help"], prog_name="ct", standalone_mode=False, obj=options)


def _set_up_logging(verbose: bool) -> None:
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(VisibleFormatter("%(levelname)s %(name)s: %(message)s"))
    logging.basicConfig(handlers=[handler], level=logging.WARNING)
    for package in ("annotation_app", "corpus_tools", "eval", "g3"):
        logging.getLogger(package).setLevel(logging.DEBUG if verbose else logging.WARNING)


def main(args: Sequence[str] | None = None) -> None:
    """Run ``ct`` with the arguments after ``ct``, or those of the process if left out, and exit."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # rather than fail on a Ψ
    sys.exit(run(sys.argv[1:] if args is None else args))


def run(args: Sequence[str]) -> int:
    """Run ``ct`` and return its exit status.

    0: done; 1: an error of ``ct`` itself, or nobody reads its output; 2: bad input or
    usage; 130: interrupted.
    """
    options: dict[str, Any] = {"verbose": False}
    try:
        result = cli.main(list(args), prog_name="ct", standalone_mode=False, obj=options)
        with about("the standard output"):
            sys.stdout.flush()
    except click.Abort as abort:
        note(_interrupted(abort.__cause__, options.get(TARGETS, [])))
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        _drop_output()
        return EXIT_UNEXPECTED
    except Exception as error:
        if isinstance(error, click.UsageError) and error.ctx is None:
            error.ctx = _context_of(args)
        if options["verbose"]:
            note("".join(traceback.format_exception(error)).rstrip("\n"))
        status = _report(error, options.get(TARGETS, []))
        try:
            sys.stdout.flush()
        except OSError:
            _drop_output()
        return status
    return result if isinstance(result, int) else 0


def _context_of(args: Sequence[str]) -> click.Context:
    """Return the context of the command that arguments name, which click's parser leaves out."""
    ctx = click.Context(cli, info_name="ct", obj={})
    for word in args:
        if isinstance(ctx.command, click.Group) and (own := ctx.command.get_command(ctx, word)):
            ctx = click.Context(own, parent=ctx, info_name=word)
    return ctx


def _drop_output() -> None:
    """Discard the output that couldn't be printed.

    The interpreter flushes again as it ends; there that would print a warning.
    """
    with contextlib.suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _interrupted(cause: BaseException | None, targets: Sequence[Path]) -> str:
    """Return the line for Ctrl-C, with the file that was, or would have been, written."""
    names = [str(name) for name in (cause.args if cause else ())] or [str(t) for t in targets]
    if not names:
        return "ct: interrupted"
    return (
        f"ct: interrupted: {', '.join(names)} isn't finished (what is there is whole: run the "
        "same command again)"
    )


def _machine_error(error: OSError | MemoryError, targets: Sequence[Path]) -> CorpusError | None:
    """Convert an error of the machine; without a file, it names the command's own target."""
    if isinstance(error, MemoryError):
        fix = "end other programs, give less at a time, or use a machine with more memory"
        return CorpusError(
            "there is not enough memory", where=", ".join(map(str, targets)), fix=fix
        )
    named = named_error(error)
    if named is None or named.where or not targets:
        return named
    return CorpusError(named.what, where=", ".join(map(str, targets)), fix=named.fix)


def _report(error: Exception, targets: Sequence[Path]) -> int:
    """Print an error in one line, or several in one line each; return the exit status."""
    if isinstance(error, (OSError, MemoryError)):
        error = _machine_error(error, targets) or error
    status = EXIT_BAD_INPUT
    if isinstance(error, click.NoSuchOption) and _belongs_before(error):
        name = error.option_name
        _complain(f"error: {name} goes before the command: ct {name} ...")
    elif isinstance(error, click.ClickException):
        shown = io.StringIO()
        if isinstance(error, click.BadParameter) and error.param is not None:
            error = _in_plain_words(error, error.param)
        error.show(file=shown)
        note(_shortened(shown.getvalue().rstrip("\n")), *_remedy(error))
    elif isinstance(error, ManyError):
        _complain(f"error: {len(error.errors)} things are wrong:")
        for one in error.errors[:MOST_LINES]:
            note(f"  {_shortened(_in_one_line(str(one)))}")
        if len(error.errors) > MOST_LINES:
            note(f"  and {len(error.errors) - MOST_LINES} more")
    elif isinstance(error, CorpusError):
        _complain(f"error: {error}")
    elif isinstance(error, ModuleNotFoundError) and (extra := extra_of(error.name or "")):
        package = str(error.name).partition(".")[0]
        _complain(
            f"error: this needs the package {package} (pip install '{DISTRIBUTION}[{extra}]')"
        )
    else:
        status = EXIT_UNEXPECTED
        _complain(
            f"unexpected error: {type(error).__name__}: {error} "
            "(run with --verbose for the traceback, please report)"
        )
    return status


def _in_plain_words(error: click.BadParameter, param: click.Parameter) -> click.BadParameter:
    """Name the numbers that an option takes, where click names a type or a range."""
    kind = param.type
    value, is_clicks, _ = error.message.partition(" is not ")
    is_number = isinstance(kind, (click.types.IntParamType, click.types.FloatParamType))
    if not is_number or not is_clicks:
        return error
    wanted = "a whole number" if isinstance(kind, click.types.IntParamType) else "a number"
    if isinstance(kind, (click.IntRange, click.FloatRange)):
        above = f" above {kind.min}" if kind.min_open else f" from {kind.min}"
        below = f" below {kind.max}" if kind.max_open else f" to {kind.max}"
        on = " on" if kind.max is None and not kind.min_open else ""
        wanted += ("" if kind.min is None else above + on) + ("" if kind.max is None else below)
    return click.BadParameter(f"{value} won't do (give {wanted}).", error.ctx, param)


def _remedy(error: click.ClickException) -> list[str]:
    """Return lines that show what to write, where an error doesn't."""
    ctx = error.ctx if isinstance(error, click.UsageError) else None
    if ctx is None:
        return []
    if isinstance(error, click.NoSuchCommand) and isinstance(ctx.command, click.Group):
        if error.possibilities and "Did you mean" in error.format_message():
            return []
        names = _names(cli, "ct") if ctx.command is cli else ()
        elsewhere = [name for name in names if name.split()[-1] == error.command_name]
        return [f"Write: {name}" for name in elsewhere] or [_commands_of(ctx.command, ctx)]
    if isinstance(error, click.NoSuchOption):
        if isinstance(ctx.command, click.Group) and not ctx.command.invoke_without_command:
            has = _commands_of(ctx.command, ctx, " Options come after these.")
        else:
            every = [p.opts[0] for p in ctx.command.params if isinstance(p, click.Option)]
            has = _wrapped(f"{ctx.command_path} has {', '.join(every)}.")
        return [] if error.possibilities else [has]
    is_missing = isinstance(error, (click.MissingParameter, click.BadOptionUsage))
    if type(error) is not click.UsageError and not is_missing:
        return []
    options = {*re.findall(r"--[a-z][a-z-]*", error.format_message())}
    examples = _examples(ctx.command)
    fitting = [one for one in examples if options <= {*one.split()}]
    has_fitting = fitting and (is_missing or len(options) > 1)  # "TEXT or --file" means neither
    return [f"Example: {one}" for one in (fitting if has_fitting else examples)[:1]]


def _commands_of(group: click.Group, ctx: click.Context, more: str = "") -> str:
    return _wrapped(f"{ctx.command_path} has {', '.join(group.list_commands(ctx))}.{more}")


def _wrapped(sentence: str) -> str:
    return textwrap.fill(sentence, COLUMNS, break_on_hyphens=False)


def _examples(command: click.Command) -> list[str]:
    """Return the examples of a command's help."""
    lines = f"{command.help}\n{command.epilog}".partition("Example")[2].splitlines()
    return [line.strip() for line in lines if line.strip().startswith("ct ")]


def _names(group: click.Group, path: str) -> Iterator[str]:
    """Yield the commands of a group and of the groups in it."""
    with click.Context(group) as ctx:
        for name in group.list_commands(ctx):
            command = group.get_command(ctx, name)
            if command is not None and not command.hidden:
                yield f"{path} {name}"
            if isinstance(command, click.Group):
                yield from _names(command, f"{path} {name}")


def _belongs_before(error: click.NoSuchOption) -> bool:
    """Check that an option that a command hasn't is one of ``ct`` itself."""
    return any(error.option_name in parameter.opts for parameter in cli.params)


def _complain(message: str) -> None:
    note("ct: " + _shortened(_in_one_line(message)))


def _in_one_line(message: str) -> str:
    return " ".join(message.split())


def _shortened(message: str) -> str:
    """Return a message without its middle, if it repeats something endless that was given."""
    if len(message) <= LONGEST_MESSAGE:
        return message
    half = LONGEST_MESSAGE // 2
    return f"{message[:half]} [{len(message) - 2 * half} characters] {message[-half:]}"
