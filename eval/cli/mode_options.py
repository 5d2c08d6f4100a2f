"""Options of several modes of ``ct eval``, and the writing of their results."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from corpus_tools.options.format_option import TARGET_FILE
from corpus_tools.runtime.terminal import say

Command = Callable[..., Any]

TRAIN = click.option(
    "--train", metavar="CORPUS,...", required=True, help="Learn from these corpora."
)
FOLLOWED = click.option("--test", metavar="CORPUS", required=True, help="Follow its commands.")
DIVIDED = click.option("--corpus", metavar="CORPUS", default="", help="A corpus to divide.")
BY_SCENARIO = click.option(
    "--cv", type=click.Choice(["scenario"]), help="Leave out each scenario of --corpus in turn."
)
TESTED = click.option("--test", metavar="CORPUS", default="", help="Test on all of a corpus.")
SEED = click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Random seed of splits, hard negatives, resamples, orders and perturbations.",
)
THRESHOLD = click.option(
    "--threshold",
    type=click.FloatRange(0, 1),
    default=0.5,
    show_default=True,
    help="Probability from which a correspondence is predicted.",
)
RATED = click.option("--corpus", metavar="CORPUS", required=True, help="The corpus with ratings.")
STUDY = click.option(
    "--study", default="", help="Count these ratings [default: the largest study]."
)
HELD_OUT = click.option(
    "--cv",
    type=click.Choice(["scenario"]),
    expose_value=False,
    help="Hold out each scenario in turn, which is always done here.",
)
MOST = click.option(
    "--most",
    type=click.IntRange(min=0),
    default=0,
    show_default="all",
    help="How many commands of each scenario to follow.",
)


def _each_once(
    _ctx: click.Context, _option: click.Parameter, value: tuple[str, ...]
) -> tuple[str, ...]:
    return tuple(dict.fromkeys(value))


PERTURB = click.option(
    "--perturb",
    type=click.Choice(["articles", "typos", "capitals", "run-on"]),
    multiple=True,
    callback=_each_once,
    help="Also test the commands without articles, with a misspelt word each, in capitals, or "
    "without punctuation; give several for a row each.",
)


def draws_option(default: int = 2000) -> Callable[[Command], Command]:
    """Add ``--draws``, the number of resamples for intervals."""
    return click.option(
        "--draws",
        type=click.IntRange(min=1),
        default=default,
        show_default=True,
        help="Resamples for the intervals.",
    )


def form_options(given: str, made: str, form: str) -> Callable[[Command], Command]:
    """Add ``--write-tasks``, and the option for its form as filled in by other programs.

    `given` is the name of that option, `made` its help, and `form` the content of the form.
    """
    taken = click.option(
        given,
        type=click.Path(path_type=Path, dir_okay=False, exists=True),
        multiple=True,
        help=f"{made}, called like the file (repeatable).",
    )
    written = click.option(
        "--write-tasks",
        "tasks",
        type=TARGET_FILE,
        help=f"Only write the form for {given}: {form}.",
    )
    return lambda command: taken(written(command))


TOP = click.option(
    "--top",
    type=click.IntRange(min=1),
    default=10,
    show_default=True,
    help="How many phrases to list of each kind.",
)


def is_terminal(out: Path | None) -> bool:
    """Check that a result is shown on a terminal, which has colours."""
    return out is None and sys.stdout.isatty()


def write(text: str, out: Path | None) -> None:
    """Write a result to a file, or to the standard output."""
    from g3.storage.atomic_file import write_bytes  # noqa: PLC0415 - `ct --help` does without

    if out is None:
        say(text, styled=True)
    else:
        write_bytes(out, f"{text}\n".encode())
