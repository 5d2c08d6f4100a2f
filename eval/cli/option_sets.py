"""Options that belong together: a command says which sets of them it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import ParamSpec, TypeVar

import click
from click.core import ParameterSource

from eval.cli.modes import all_of, any_of

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class OptionSet:
    """Options that are given together."""

    needs: tuple[str, ...] = ()
    """Those that make the set."""
    may: tuple[str, ...] = ()
    """Those that may be added to them."""

    def __str__(self) -> str:
        return all_of(self.needs)


def takes_one_of(*sets: OptionSet) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Have a command refuse options unless they are one of some sets.

    Options that no set has are free.
    """

    def decorate(command: Callable[P, T]) -> Callable[P, T]:
        @wraps(command)
        def checked(*args: P.args, **kwargs: P.kwargs) -> T:
            check(click.get_current_context(), sets)
            return command(*args, **kwargs)

        return checked

    return decorate


def check(ctx: click.Context, sets: tuple[OptionSet, ...]) -> None:
    """Refuse what was given unless it is one of some sets; the error says what may be given."""
    given = [p.opts[0] for p in ctx.command.params if _is_given(ctx, p)]
    deciding = {option for one in sets for option in one.needs}
    own = next((one for one in sets if {*one.needs} == deciding & {*given}), None)
    if own is None:
        raise click.UsageError(f"Give {any_of(str(one) for one in sets if one.needs)}.", ctx)
    for option in given:
        having = [one for one in sets if option in one.may]
        if having and own not in having:
            why = f"doesn't go with {own}" if own.needs else f"goes with {any_of(map(str, having))}"
            raise click.UsageError(f"{option} {why}.", ctx)


def _is_given(ctx: click.Context, parameter: click.Parameter) -> bool:
    """Whether somebody gave an option that isn't the same as giving none."""
    name = str(parameter.name)
    if ctx.get_parameter_source(name) in (ParameterSource.DEFAULT, None):
        return False
    return ctx.params.get(name) not in (None, False, "", ())
