"""Commands that an option chooses too, such as ``--table 1``, and options of several commands."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import click
from click.core import ParameterSource

from corpus_tools.options import TARGET_FILE, ExistingPath, corpus_option
from corpus_tools.runtime.terminal import say
from g3.errors import nearest

if TYPE_CHECKING:
    from eval.judging.judge_registry import PlanJudge
    from eval.language_model.chat_endpoint import Endpoint, Form
    from eval.parsing.parser_registry import TextParser

P = ParamSpec("P")
T = TypeVar("T")


class Modes(click.Group):
    """A group whose commands are also chosen by an option, as in version 0.2.0.

    ``eval --table 1 ...`` is ``eval table1 ...``, and ``eval ... --report FOLDER`` is ``eval report
    ... FOLDER``.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        """List the commands in the order in which they were added."""
        return list(self.commands)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put a command that an option chooses before its arguments."""
        words = list(args)
        for place, word in enumerate(words):
            if word in self.commands:
                break
            option, equals, value = word.partition("=")
            if option == "--table":
                number = value or "".join(words[place + 1 : place + 2])
                words[place : place + (1 if equals else 2)] = []
                words.insert(0, f"table{number}")
                break
            if word.startswith("--") and option[2:] in self.commands:
                words[place : place + 1] = [value] if equals else []
                words.insert(0, option[2:])
                break
        try:
            return super().parse_args(ctx, words)
        except click.NoSuchOption as error:
            option, names = error.option_name, [n for n in self.commands if n[:5] != "table"]
            if having := self._having(option):
                what = f"Name a command before {option}, which is for {all_of(having)}."
                raise click.UsageError(what, ctx) from None
            near = nearest(option, ["--table", *(f"--{name}" for name in names)])
            raise click.NoSuchOption(option, possibilities=near, ctx=ctx) from None

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; the error for an option that only others have names these."""
        try:
            return super().invoke(ctx)
        except click.NoSuchOption as error:
            own, option = ctx.invoked_subcommand or "", error.option_name
            having = self._having(option)
            if option[2:] in self.commands:
                raise click.UsageError(f"Give one of {own} and {option[2:]}.", ctx) from error
            if having:
                what = f"{option} doesn't go with {own}; it is for {all_of(having)}."
                raise click.UsageError(what, error.ctx) from error
            raise

    def _having(self, option: str) -> list[str]:
        return [n for n, c in self.commands.items() if any(option in p.opts for p in c.params)]


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
    matching = next((one for one in sets if {*one.needs} == deciding & {*given}), None)
    if matching is None:
        begun = deciding & {*given}
        having = [one for one in sets if one.needs and begun <= {*one.needs}]
        fitting = having or [one for one in sets if one.needs]
        raise click.UsageError(f"Give {'; or '.join(map(str, fitting))}.", ctx)
    for option in given:
        having = [one for one in sets if option in one.may]
        if having and matching not in having:
            why = (
                f"doesn't go with {matching}"
                if matching.needs
                else f"goes with {any_of(map(str, having))}"
            )
            raise click.UsageError(f"{option} {why}.", ctx)


def _is_given(ctx: click.Context, parameter: click.Parameter) -> bool:
    """Check that an option is given with a value that differs from giving none."""
    name = str(parameter.name)
    if ctx.get_parameter_source(name) in (ParameterSource.DEFAULT, None):
        return False
    return ctx.params.get(name) not in (None, False, "", ())


Command = Callable[..., Any]


def by_scenario(name: str, *others: str, **about: Any) -> Callable[[Command], Command]:
    """Make an option whose value is "scenario", also if it is left out, or one of some others."""
    values = click.Choice(["scenario", *others])
    return click.option(name, type=values, is_flag=False, flag_value="scenario", **about)


TRAIN = corpus_option(
    "--train",
    metavar="CORPUS,...",
    default="",
    help="Learn from these corpora [default: the other scenarios of --test].",
)
FOLLOWED = corpus_option("--test", required=True, help="Follow its commands.")
DIVIDED = corpus_option("--corpus", default="", help="A corpus to divide.")
BY_SCENARIO = by_scenario("--cv", help="Leave out each scenario of --corpus in turn.")
TESTED = corpus_option("--test", default="", help="Test on all of a corpus.")
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
STUDY = click.option(
    "--study", default="", help="Count these ratings [default: the largest study]."
)
HELD_OUT = by_scenario(
    "--cv", expose_value=False, help="Hold out each scenario in turn, which is always done here."
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
        type=ExistingPath(dir_okay=False),
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


VERBOSE = click.option(
    "--verbose", is_flag=True, help="Add figures by other methods, and comparisons."
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


NAME = "llm"
"""Name of the language model for ``--grounder``, ``--parser`` and ``--judge``."""
_PURPOSES = {
    "grounders": "--grounder",
    "parsers": "--parser",
    "parser": "--parser",
    "judge": "--judge",
}
"""Options that can name the language model, by the parameters that have their values."""


def _price(_ctx: click.Context, _option: click.Parameter, value: str) -> tuple[float, float] | None:
    if not value:
        return None
    try:
        prompt, completion = (float(part) for part in value.split(","))
    except ValueError:
        raise click.BadParameter("give two numbers, such as 0.15,0.60") from None
    return prompt, completion


_OPTIONS = (
    click.option(
        "--llm", metavar="MODEL", default="", help="Name of the language model at --endpoint."
    ),
    click.option(
        "--endpoint",
        metavar="URL",
        default="",
        help="Where the language model is, such as http://localhost:8000/v1. Without it nothing is "
        "ever sent (extra: llm).",
    ),
    click.option(
        "--replies",
        type=click.Path(path_type=Path, file_okay=False),
        help="Keep the language model's replies in this folder, so that no request is sent twice "
        "[default: in the cache].",
    ),
    click.option(
        "--at-once",
        type=click.IntRange(1, 256),
        default=8,
        show_default=True,
        help="How many requests to the language model are under way at the same time.",
    ),
    click.option(
        "--wait",
        "wait_s",
        type=click.FloatRange(min=0, min_open=True),
        default=120.0,
        show_default=True,
        help="How many seconds to wait for a reply of the language model.",
    ),
    click.option(
        "--reply-form",
        type=click.Choice(["schema", "object", "none"]),
        default="schema",
        show_default=True,
        help="How the server is held to JSON: by a schema, as an object, or by the prompt only.",
    ),
    click.option(
        "--price",
        metavar="IN,OUT",
        default="",
        callback=_price,
        help="Dollars for a million tokens of prompts and of replies, to show what a run costs.",
    ),
)


def language_model_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options; the command gets an ``endpoint``, which is None if none is given."""

    @functools.wraps(command)
    def with_endpoint(
        *args: Any,
        llm: str,
        endpoint: str,
        replies: Path | None,
        at_once: int,
        wait_s: float,
        price: tuple[float, float] | None,
        reply_form: Form,
        **options: Any,
    ) -> Any:
        purposes = [option for name, option in _PURPOSES.items() if name in options]
        is_needed = any(
            value == NAME or (isinstance(value, tuple) and NAME in value)
            for value in map(options.get, _PURPOSES)
        )
        if options.get("llm_trees", 1) > 1 and NAME not in (
            options.get("parser"),
            *options.get("parsers", ()),
        ):
            raise click.UsageError("--llm-trees is for --parser llm.")
        if bool(llm) != bool(endpoint):
            raise click.UsageError("Give --llm and --endpoint together.")
        if is_needed and not endpoint:
            raise click.UsageError("A language model needs --llm and --endpoint.")
        if endpoint and not is_needed:
            raise click.UsageError(f"Say what to ask the language model for: {any_of(purposes)}.")
        made = None
        if endpoint:
            import secrets  # noqa: PLC0415 - `ct --help` does without

            from eval.language_model import chat_endpoint  # noqa: PLC0415
            from eval.language_model.model_answers import check_installed  # noqa: PLC0415
            from g3.storage.cache_folder import cache_folder  # noqa: PLC0415

            check_installed()
            made = chat_endpoint.Endpoint(
                endpoint.rstrip("/"),
                llm,
                str((replies or cache_folder() / "replies").absolute()),
                seed=options.get("seed", 0),
                at_once=at_once,
                timeout_s=wait_s,
                price=price,
                form=reply_form,
                run=secrets.token_hex(8),
            )
        return command(*args, endpoint=made, **options)

    decorated: Callable[..., Any] = with_endpoint
    for option in reversed(_OPTIONS):
        decorated = option(decorated)
    return decorated


LLM_TREES = click.option(
    "--llm-trees",
    type=click.IntRange(1, 20),
    default=1,
    show_default=True,
    help="How many trees of a text to ask the language model for, as a parser, at most, each with "
    "its share.",
)


def judge_of(name: str, endpoint: Endpoint | None) -> PlanJudge:
    """Return the judge with a name; ``llm`` is the language model at an endpoint."""
    from eval.judging.judge_registry import judge_named  # noqa: PLC0415 - `ct --help` does without
    from eval.language_model.model_answers import LanguageModelJudge  # noqa: PLC0415 - `ct --help` does without

    return LanguageModelJudge(endpoint) if name == NAME and endpoint else judge_named(name)


def parser_of(name: str, endpoint: Endpoint | None, trees: int = 1) -> TextParser:
    """Return the parser with a name; ``llm`` is the language model at an endpoint."""
    if name == NAME and endpoint:
        from eval.language_model.model_answers import LanguageModelParser  # noqa: PLC0415 - `ct --help` does without

        return LanguageModelParser(endpoint, trees)
    from eval.parsing.parser_registry import parser_named  # noqa: PLC0415 - `ct --help` does without

    return parser_named(name)


def used_of(
    endpoint: Endpoint | None, *, plans: bool = False, parses: bool = False, judge: bool = False
) -> dict[str, Mapping[str, object]]:
    """Return a run's usage of a language model, by purpose."""
    if endpoint is None:
        return {}
    from eval.language_model.chat_endpoint import usage  # noqa: PLC0415 - `ct --help` does without
    from eval.language_model.model_answers import JUDGE, PARSE, PLAN  # noqa: PLC0415 - `ct --help` does without

    purposes = {PLAN: plans, PARSE: parses, JUDGE: judge}
    return {purpose: usage(endpoint, purpose) for purpose, is_asked in purposes.items() if is_asked}
