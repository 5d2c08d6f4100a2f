"""Options of the commands that train a model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from corpus_tools.options.format_option import with_default

Command = Callable[..., Any]


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
