"""Options and arguments that commands share.

Every command with a result can print it as JSON, alone on the standard output; progress,
notes and problems go to the standard error. ``--json`` is short for ``--format json``.
"""

from __future__ import annotations

import functools
import json
import os
import shlex
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from corpus_tools.runtime.terminal import say
from g3.errors import FormatError, unknown_name

PLAIN = "text"
"""The format for people, which is the default everywhere."""
_SHORT = f"{__name__}.json"

Command = Callable[..., Any]


class _Form(click.Choice[str]):
    """The formats; "table", as the plain one of `ct eval` was first called, is still understood."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return super().convert(PLAIN if value == "table" else value, param, ctx)


PATH = click.Path(path_type=Path)
"""A file or a folder, whether or not it is there."""
TARGETS = "targets"
"""Key of the paths that a command writes to, in the first context's object, a dictionary."""


class ExistingPath(click.Path):
    """A file or a folder that is there; else the error has names like it, and a remedy."""

    def __init__(self, fix: str = "", **about: Any) -> None:
        super().__init__(path_type=Path, **about)
        self.fix = fix

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path, or fail with a remedy."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        with suppress(OSError):
            if path.exists():
                return path
        siblings: list[str] = []
        with suppress(OSError):
            siblings = [
                str(sibling) for sibling in path.parent.iterdir() if _of_a_kind(sibling, path)
            ]
        _, fix = unknown_name("file", path, siblings, more=self.fix)
        raise click.BadParameter(f"there is no {str(path)!r} ({fix})", ctx, param)


def _of_a_kind(one: Path, other: Path) -> bool:
    """Check that paths end alike, or differ in their ends only."""
    return one.suffix == other.suffix or one.stem == other.stem


class _Target(click.Path):
    """A path that is written to, in a folder that is there; errors of the machine name it."""

    def __init__(self, **about: Any) -> None:
        super().__init__(path_type=Path, **about)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        folder = path.absolute().parent
        if not folder.is_dir():
            raise FormatError("there is no such folder", where=str(folder), fix="make it first")
        if ctx is not None and isinstance(shared := ctx.find_root().obj, dict):
            shared.setdefault(TARGETS, []).append(path)
        return path


TARGET = _Target()
TARGET_FILE = _Target(dir_okay=False)
TARGET_FOLDER = _Target(file_okay=False)
"""A file or folder that a command writes. The folder that it is in must be there."""


def with_default(*names: str, **about: Any) -> Callable[[Command], Command]:
    """Make an option whose help shows its default."""
    return click.option(*names, show_default=True, **about)


def format_option(
    *others: str, about: str = "For people or for programs."
) -> Callable[[Command], Command]:
    """Add ``--format`` and ``--json``; the command gets the format as ``form``.

    `others` are formats other than ``text`` and ``json``; `about` describes each format.
    """
    long = click.option(
        "--format",
        "form",
        type=_Form([PLAIN, "json", *others]),
        default=PLAIN,
        show_default=True,
        callback=_chosen,
        help=about,
    )
    short = click.option(
        "--json",
        "json_",
        is_flag=True,
        is_eager=True,  # so that `--format` is read after it
        expose_value=False,
        callback=_noted,
        help="Short for --format json.",
    )
    return lambda command: long(short(command))


def out_file(about: str, metavar: str | None = None) -> Callable[[Command], Command]:
    """Add ``--out`` for output that is written as a whole, in an existing folder."""
    return click.option("--out", required=True, metavar=metavar, type=TARGET, help=about)


def out_folder(about: str, metavar: str | None = None) -> Callable[[Command], Command]:
    """Add ``--out`` for a folder that is made if it isn't there; the folder around it must be."""
    return click.option("--out", required=True, metavar=metavar, type=TARGET_FOLDER, help=about)


def tell(form: str, record: object, *lines: str) -> None:
    """Print a record as JSON if that is wanted, else the lines for people.

    It is built of what msgspec writes: dataclasses, structs, mappings, sequences, and paths.
    """
    if form != "json":
        say(*lines)
        return
    say(as_json(record))


def as_json(record: object) -> str:
    """Format a record as indented JSON, in ASCII where the standard output needs it."""
    import msgspec  # noqa: PLC0415 - `ct --help` does without

    is_unicode = (sys.stdout.encoding or "").lower().replace("-", "") == "utf8"
    content = msgspec.json.decode(msgspec.json.encode(record, enc_hook=os.fspath))
    return json.dumps(content, indent=2, ensure_ascii=not is_unicode)


def _noted(ctx: click.Context, _: click.Parameter, is_short: bool) -> None:
    ctx.meta[_SHORT] = is_short


def _chosen(ctx: click.Context, parameter: click.Parameter, form: str) -> str:
    if not ctx.meta.get(_SHORT):
        return form
    name = str(parameter.name)
    if form != "json" and ctx.get_parameter_source(name) is ParameterSource.COMMANDLINE:
        raise click.UsageError(f"Give either --json or --format {form}.")
    ctx.set_parameter_source(name, ParameterSource.COMMANDLINE)
    return "json"


FORMAT = format_option()
JSON = click.option("--json", "as_json", is_flag=True, help="Print what was made as JSON.")
"""For a command whose ``--format`` is that of the files it makes."""
OUT = click.option("--out", type=TARGET, help="Write to a file instead of the standard output.")


class _CorpusName(click.ParamType[str]):
    """The name of a bundled corpus, or a corpus's folder."""

    name = "text"

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None) -> str:
        return f"Give a corpus's folder or name, such as {param.opts[0]} warehouse."

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from corpus_tools.runtime.shipped import bundled  # noqa: PLC0415 - `ct --help` does without

        named = [CompletionItem(n) for n in bundled() if n.startswith(incomplete)]
        return [*named, CompletionItem(incomplete, type="dir")]


def corpus_option(
    *names: str, metavar: str = "CORPUS", **about: Any
) -> Callable[[Command], Command]:
    """Make an option that names a corpus."""
    return click.option(*names, metavar=metavar, type=_CorpusName(), **about)


def training_options(command: Command) -> Command:
    """Add the options of a model's features and training."""
    return selection_options(L2(command))


def selection_options(command: Command) -> Command:
    """Add the options that say which examples and features there are."""
    for option in reversed(_SELECTION):
        command = option(command)
    return command


NEGATIVES_SEED = with_default(
    "--seed", type=click.IntRange(min=0), default=0, help="Random seed of hard negatives."
)
NEGATIVES = with_default(
    "--negatives",
    type=click.Choice(["random", "hard"]),
    default="random",
    help="The corpus's own, or other plausible groundings in the same scene.",
)
L2 = click.option(
    "--l2", type=click.FloatRange(min=0, min_open=True), help="Strength of the regularisation."
)
ABLATE = click.option(
    "--ablate",
    metavar="NAME",
    multiple=True,
    help="Leave out a feature set, or a potential of the search for plans (repeatable).",
)
_SELECTION = (
    NEGATIVES,
    ABLATE,
    click.option(
        "--with", "plus", metavar="NAME", multiple=True, help="Add a feature set (repeatable)."
    ),
)


def WORKERS(command: Command) -> Command:  # noqa: N802 - as options are
    """Add ``--jobs`` and ``--scheduler``; the command gets both as ``workers``."""

    @with_default(
        "--jobs",
        type=click.IntRange(1),
        default=1,
        help="How many processes work at the same time.",
    )
    @click.option(
        "--scheduler",
        metavar="ADDRESS",
        default="",
        help="Work on a Dask cluster, whose workers see the same files (extra: cluster).",
    )
    @functools.wraps(command)
    def with_workers(*args: Any, jobs: int, scheduler: str, **options: Any) -> Any:
        from corpus_tools.runtime.parallel import Workers  # noqa: PLC0415 - `ct --help` does without

        return command(*args, workers=Workers(jobs, scheduler), **options)

    return with_workers


def text_argument(name: str) -> Callable[[Command], Command]:
    """Add an argument for one text, which may be left out.

    A text of several arguments wasn't quoted; the error shows it quoted. A file goes elsewhere.
    """
    shown = f"[{name.upper()}]"
    return click.argument(name, metavar=shown, nargs=-1, callback=_in_one)


def _in_one(ctx: click.Context, _: click.Parameter, words: tuple[str, ...]) -> str | None:
    if len(words) > 1:
        # Nobody says an underscore: a word with one is a scenario, before or after the command.
        names = [word for word in words if "_" in word]
        quoted = shlex.quote(" ".join(word for word in words if word not in names))
        if len(names) == 1 and any("--scenario" in p.opts for p in ctx.command.params):
            line = f"{ctx.command_path} {quoted} --scenario {names[0]}"
            raise click.UsageError(f"Name the scenario by its option: {line}", ctx)
        quoted = shlex.quote(" ".join(words))
        raise click.UsageError(f"Put the text in quotes: {ctx.command_path} {quoted}", ctx)
    if words and any("--file" in p.opts for p in ctx.command.params) and _is_file(words[0]):
        raise click.UsageError(f"{words[0]} is a file. Write: {ctx.command_path} --file {words[0]}")
    return words[0] if words else None


def _is_file(text: str) -> bool:
    """Check that a text is a file's path; a long text is none, for which the machine has errors."""
    with suppress(OSError, ValueError):
        return Path(text).is_file()
    return False
