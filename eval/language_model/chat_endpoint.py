"""Requests to a language model at an endpoint with OpenAI's protocol of chat completions.

Nothing is sent without a named endpoint. A request with a kept reply isn't sent.
"""

from __future__ import annotations

import functools
import os
import random
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from eval.language_model.kept_replies import (
    KeptReply,
    Origin,
    ReplyFolder,
    Tokens,
    UnderWay,
    key_of,
    now,
    open_folder,
)
from g3.errors import CorpusError

if TYPE_CHECKING:
    import openai
    from openai.types.chat import ChatCompletion

KEY_VARIABLE = "CT_LLM_KEY"
"""The environment variable with the endpoint's key; local servers need none."""
MISSING = "the package openai isn't installed: pip install 'corpus-tools-g3[llm]'"
FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 30.0
UNPAID_STATUS = 429
"""HTTP status of a request that was refused for its rate, and cost nothing."""

Message = dict[str, str]
Form: TypeAlias = Literal["schema", "object", "none"]
"""Form of a request for JSON: ``schema`` as in OpenAI's current protocol; ``object`` for servers
that know only ``json_object``, with the schema beside it; or ``none``: in the prompt alone."""
FORMS: tuple[Form, ...] = get_args(Form)


@dataclass(frozen=True)
class Endpoint:
    """A language model at an endpoint, with its request settings.

    Parameters
    ----------
    url
        Address of the endpoint, such as ``http://localhost:8000/v1``.
    folder
        Folder of kept replies.
    seed, temperature
        Sent with requests, so that servers that support it give reproducible replies.
    at_once
        Number of requests at the same time.
    tries
        Number of attempts at a request that fails.
    price
        Dollars for a million tokens of prompts, and of completions.
    form
        Form of requests for JSON; see :data:`FORMS`.
    run
        Name of the run under which the use of replies is noted.
    """

    url: str
    model: str
    folder: str
    seed: int = 0
    temperature: float = 0.0
    at_once: int = 8
    timeout_s: float = 120.0
    tries: int = 5
    price: tuple[float, float] | None = None
    form: Form = "schema"
    run: str = field(default="run", compare=False)

    @property
    def about(self) -> Mapping[str, object]:
        """Settings that decide its replies."""
        return {
            "endpoint": self.url,
            "model": self.model,
            "seed": self.seed,
            "temperature": self.temperature,
        }

    @property
    def replies(self) -> ReplyFolder:
        """Folder of its kept replies."""
        return open_folder(Path(self.folder))


def missing() -> str:
    """Return why no language model can be reached here; empty if one can."""
    try:
        import openai  # noqa: F401, PLC0415 - comes with the extra "llm"
    except ImportError:
        return MISSING
    return ""


def ask(
    endpoint: Endpoint, messages: Sequence[Message], schema: Mapping[str, Any], *, purpose: str
) -> KeptReply:
    """Return the reply to messages: the kept one, or else the endpoint's.

    Parameters
    ----------
    schema
        JSON Schema of the reply.
    purpose
        Purpose of the request: ``plan`` or ``judge``.

    Raises
    ------
    CorpusError
        If there is no reply after several tries, or the endpoint refuses the request.
    """
    request = {
        "model": endpoint.model,
        "messages": list(messages),
        "temperature": endpoint.temperature,
        "seed": endpoint.seed,
    } | _form(endpoint.form, purpose, dict(schema))
    key, folder = key_of(endpoint.url, request), endpoint.replies
    reply = folder.reply(key)
    if reply is not None:
        folder.used(endpoint.run, purpose, key, "kept")
        return reply
    with folder.asking(key) as known:
        reply = folder.reply(key)  # somebody else may have asked meanwhile
        origin: Origin = "kept" if reply else "new"
        if reply is None:
            reply = _sent(endpoint, request, key, known)
            folder.keep(key, reply)
    folder.used(endpoint.run, purpose, key, origin)
    return reply


def _form(form: Form, purpose: str, schema: dict[str, Any]) -> dict[str, Any]:
    """Return the part of a request that requests the form of its reply."""
    if form == "none":
        return {}
    told = {"type": "json_schema", "json_schema": {"name": purpose, "schema": schema}}
    if form == "object":
        told = {"type": "json_object", "schema": schema}
    return {"response_format": told}


def _sent(endpoint: Endpoint, request: dict[str, Any], key: str, known: UnderWay) -> KeptReply:
    """Send a request until it is answered; possible charges are noted first."""
    import openai  # noqa: PLC0415 - comes with the extra "llm"

    client, folder = _client(endpoint), endpoint.replies
    for tried in range(endpoint.tries):
        known.sent += 1
        folder.note(key, known)
        asked, begun = now(), time.monotonic()
        try:
            # Servers that know the header answer a repeated request without doing it again.
            answer = client.chat.completions.create(
                **request, extra_headers={"Idempotency-Key": key}
            )
        except openai.APIStatusError as error:
            status, problem = error.status_code, f"{error.status_code} {_said(error)}"
            if status == UNPAID_STATUS or status < 500:
                known.unpaid += 1
                folder.note(key, known)
            if status < 500 and status not in (408, 409, UNPAID_STATUS):
                raise CorpusError(
                    f"the endpoint refuses the request: {problem}",
                    where=endpoint.url,
                    fix=f"check --endpoint and --llm, and the key in {KEY_VARIABLE} if it needs "
                    "one",
                ) from error
            wait = error.response.headers.get("retry-after", "")
        except openai.APIConnectionError as error:
            problem, wait = str(error.__cause__ or error), ""
            if type(error.__cause__).__name__ == "ConnectError":  # it has never arrived
                known.unpaid += 1
                folder.note(key, known)
        else:
            took = time.monotonic() - begun
            return _kept(endpoint, request, answer, known, asked=asked, latency_s=took)
        if tried + 1 < endpoint.tries:
            time.sleep(_wait_s(tried, wait))
    raise CorpusError(
        f"the language model gives no answer after {endpoint.tries} tries: {problem}",
        where=endpoint.url,
        fix="run the same command again when it is there; replies that came are kept. "
        "If it does not know the form of replies, give --reply-form object or none",
    )


def _kept(
    endpoint: Endpoint,
    request: dict[str, Any],
    answer: ChatCompletion,
    known: UnderWay,
    *,
    asked: str,
    latency_s: float,
) -> KeptReply:
    usage = answer.usage
    tokens = Tokens(usage.prompt_tokens, usage.completion_tokens) if usage else Tokens()
    choices = answer.choices or []
    return KeptReply(
        endpoint=endpoint.url,
        request=request,
        text=(choices[0].message.content or "") if choices else "",
        model=answer.model or "",
        fingerprint=answer.system_fingerprint or "",
        tokens=tokens,
        latency_s=round(latency_s, 3),
        asked=asked,
        tries=known.sent,
        in_doubt=known.sent - known.unpaid - 1,
    )


def _said(error: openai.APIStatusError) -> str:
    """Return the endpoint's error message, shortened."""
    body = error.body
    said = body.get("message") if isinstance(body, dict) else body
    return str(said or error.message)[:300]


def _wait_s(tried: int, asked_for: str) -> float:
    """Return the wait in seconds: the endpoint's wish, or twice the last one."""
    try:
        return min(float(asked_for), LONGEST_WAIT_S)
    except ValueError:
        doubled = FIRST_WAIT_S * 2.0**tried
        return min(doubled, LONGEST_WAIT_S) * random.uniform(0.75, 1.25)  # noqa: S311 - no secret


@functools.lru_cache(maxsize=4)
def _client(endpoint: Endpoint) -> openai.OpenAI:
    import openai  # noqa: PLC0415 - comes with the extra "llm"

    return openai.OpenAI(
        base_url=endpoint.url,
        api_key=os.environ.get(KEY_VARIABLE) or "none",
        timeout=endpoint.timeout_s,
        max_retries=0,  # they are counted here
    )
