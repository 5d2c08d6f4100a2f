"""Options for the language model, its endpoint and its price."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from eval.judging.judge_registry import PlanJudge
    from eval.language_model.chat_endpoint import Endpoint, Form

NAME = "llm"
"""Name of the language model for ``--grounder`` and ``--judge``."""


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
        asked = NAME in (options.get("judge"), *options.get("grounders", ()))
        if bool(llm) != bool(endpoint):
            raise click.UsageError("Give --llm and --endpoint together.")
        if asked and not endpoint:
            raise click.UsageError("A language model needs --llm and --endpoint.")
        if endpoint and not asked:
            raise click.UsageError("Say what to ask the language model for: --grounder or --judge.")
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


def judge_of(name: str, endpoint: Endpoint | None) -> PlanJudge:
    """Return the judge with a name; ``llm`` is the language model at an endpoint."""
    from eval.judging.judge_registry import judge_named  # noqa: PLC0415 - `ct --help` does without
    from eval.language_model.model_answers import LanguageModelJudge  # noqa: PLC0415 - `ct --help` does without

    return LanguageModelJudge(endpoint) if name == NAME and endpoint else judge_named(name)


def used_of(
    endpoint: Endpoint | None, *, plans: bool = False, judge: bool = False
) -> dict[str, Mapping[str, object]]:
    """Return a run's usage of a language model, by purpose."""
    if endpoint is None:
        return {}
    from eval.language_model.model_answers import JUDGE, PLAN  # noqa: PLC0415 - `ct --help` does without
    from eval.language_model.usage import usage  # noqa: PLC0415 - `ct --help` does without

    asked = {PLAN: plans, JUDGE: judge}
    return {purpose: usage(endpoint, purpose) for purpose, is_asked in asked.items() if is_asked}
