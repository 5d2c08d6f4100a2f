"""Commands with modes, such as ``--table 1`` and ``--sdc``, and options that go together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import wraps
from itertools import islice
from typing import Any, ParamSpec, TypeVar

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from g3.errors import nearest

P = ParamSpec("P")
T = TypeVar("T")


class Modes(click.Group):
    """A group with commands chosen by an option, at any place among the arguments.

    The name of a command is the option that chooses it. It is a flag (``--errors``), an option with
    a value (``--table 1``), or an option of the command (``--report``, which takes a folder).
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        """List the modes in the order in which they were added."""
        return list(self.commands)

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return the options that choose a mode, for shells to complete; the help lists modes."""
        return [*self._choosing().values(), *super().get_params(ctx)]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Find the mode and leave the other arguments to it."""
        helping = [word for word in args if word in ctx.help_option_names][:1]
        chosen, used, rest = self._sorted([word for word in args if word not in helping])
        if not chosen and (helping or ctx.resilient_parsing):
            return super().parse_args(ctx, helping)
        if not chosen:
            self._suggest_mode(ctx, used)
        if len(chosen) != 1:
            raise click.UsageError(f"Give one of {all_of(chosen or self.commands)}.", ctx)
        (name,) = chosen
        if name in self.commands:
            self._check_options(ctx, name, used)
        elif not ctx.resilient_parsing:
            option = name.partition(" ")[0]
            known = any_of(one for one in self.commands if one.startswith(f"{option} "))
            raise click.UsageError(f"There is no {name}; give {known}.", ctx)
        # What comes after two dashes isn't read as the group's own options.
        return super().parse_args(ctx, ["--", name, *(helping or rest)])

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the modes, each with its option's argument."""
        shown = {self._shown(name): mode for name, mode in self.commands.items()}
        limit = formatter.width - 6 - max(map(len, shown))
        with formatter.section("Modes"):
            formatter.write_dl([(n, mode.get_short_help_str(limit)) for n, mode in shown.items()])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete the options that choose a mode."""
        return [
            CompletionItem(name, help=option.help)
            for name, option in self._choosing().items()
            if name.startswith(incomplete)
        ]

    def _sorted(self, args: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
        """Split arguments into the chosen modes, all options given, and a mode's arguments."""
        known = {n: option for mode in self.commands.values() for n, option in _options(mode)}
        choosing = self._choosing()
        chosen: list[str] = []
        used: list[str] = []
        rest: list[str] = []
        words = iter(args)
        for word in words:
            name, equals, value = word.partition("=")
            option = choosing.get(name) or known.get(name)
            given = [word]
            if option and not option.is_flag and not equals:
                given += islice(words, 1)
                value = "".join(given[1:])
            if name in choosing:
                chosen.append(name if name in self.commands else f"{name} {value}".strip())
            if name in known or name not in choosing:
                used.append(name)
                rest += given
        return list(dict.fromkeys(chosen)), used, rest

    def _suggest_mode(self, ctx: click.Context, used: Iterable[str]) -> None:
        """Refuse an option that nearly chooses a mode, and say which it may stand for."""
        known = {option for mode in self.commands.values() for option, _ in _options(mode)}
        for option in (word for word in used if word.startswith("-") and word not in known):
            near = nearest(option, self._choosing())
            error = click.NoSuchOption(option, possibilities=near, ctx=ctx)
            if error.possibilities:
                raise error

    def _check_options(self, ctx: click.Context, name: str, used: Iterable[str]) -> None:
        """Refuse options that only other modes have, and say which do."""
        own = dict(_options(self.commands[name]))
        for option in used:
            having = [n for n, mode in self.commands.items() if option in dict(_options(mode))]
            if having and option not in own:
                where = click.Context(self.commands[name], parent=ctx, info_name=name)
                raise click.UsageError(
                    f"{option} doesn't go with {name}; it is for {all_of(having)}.", where
                )

    def _choosing(self) -> dict[str, click.Option]:
        """Return the options that choose a mode, by name."""
        found: dict[str, click.Option] = {}
        for name, mode in self.commands.items():
            option, _, value = name.partition(" ")
            own = dict(_options(mode)).get(option)
            about = mode.get_short_help_str(100)
            takes: click.ParamType[Any] | None = own.type if own else None
            if value:
                values = [n.partition(" ")[2] for n in self.commands if n.startswith(f"{option} ")]
                about, takes = f"Choose {any_of(values)}.", click.Choice(values)
            found[option] = click.Option(
                [option], type=takes, is_flag=not takes, help=about, hidden=True, expose_value=False
            )
        return found

    def _shown(self, name: str) -> str:
        own = dict(_options(self.commands[name])).get(name)
        return f"{name} {own.metavar}" if own else name


def any_of(names: Iterable[str]) -> str:
    """Join names by "or", for a sentence."""
    return _joined(list(names), "or")


def all_of(names: Iterable[str]) -> str:
    """Join names in a sentence."""
    return _joined(list(names), "and")


def _joined(names: Sequence[str], word: str) -> str:
    *others, last = names
    if len(others) < 2:
        return f" {word} ".join(names)
    return f"{', '.join(others)}, {word} {last}"


def _options(command: click.Command) -> list[tuple[str, click.Option]]:
    return [(n, p) for p in command.params if isinstance(p, click.Option) for n in p.opts]


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
    """Refuse options that are none of some sets; the error lists the allowed ones."""
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
    """Check that an option is given with a value that differs from giving none."""
    name = str(parameter.name)
    if ctx.get_parameter_source(name) in (ParameterSource.DEFAULT, None):
        return False
    return ctx.params.get(name) not in (None, False, "", ())
