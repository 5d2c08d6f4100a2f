"""Requests to a language model at an endpoint with OpenAI's protocol of chat completions.

Nothing is sent without a named endpoint. A request with a kept reply isn't sent.
"""

from __future__ import annotations

import contextlib
import datetime
import functools
import hashlib
import logging
import os
import random
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import msgspec
import numpy as np

from g3.errors import CorpusError
from g3.storage.atomic_file import write_bytes

if TYPE_CHECKING:
    import openai
    from openai.types.chat import ChatCompletion

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

logger = logging.getLogger(__name__)

Origin = Literal["new", "kept"]


class Tokens(msgspec.Struct, frozen=True):
    """Numbers of tokens that an endpoint has counted."""

    prompt: int = 0
    completion: int = 0


class KeptReply(msgspec.Struct, frozen=True, kw_only=True):
    """A reply as it is kept.

    Parameters
    ----------
    request
        The request as sent, with the prompt, the model and the seed.
    model, fingerprint
        Model and fingerprint as reported by the endpoint.
    latency_s
        From sending the request that was answered to its answer.
    asked
        Time of the request, in UTC.
    tries
        Number of times that the request was sent.
    in_doubt
        Number of these that may have been paid for without an answer.
    """

    endpoint: str
    request: dict[str, Any]
    text: str
    model: str = ""
    fingerprint: str = ""
    tokens: Tokens = Tokens()
    latency_s: float = 0.0
    asked: str = ""
    tries: int = 1
    in_doubt: int = 0


class UnderWay(msgspec.Struct):
    """A request under way: number of times sent, and number of failures."""

    sent: int = 0
    unpaid: int = 0


@dataclass(frozen=True, slots=True)
class ReplyFolder:
    """A folder of kept replies."""

    path: Path

    def reply(self, key: str) -> KeptReply | None:
        """Return the reply to a request; None if there is no readable one."""
        path = self._reply(key)
        try:
            return msgspec.json.decode(path.read_bytes(), type=KeptReply)
        except FileNotFoundError:
            return None
        except (OSError, msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
            logger.warning("%s: the reply is damaged, so that it is asked for again", path)
            return None

    def keep(self, key: str, reply: KeptReply) -> None:
        """Keep a reply; from then on its request isn't sent again."""
        write_bytes(self._reply(key), msgspec.json.format(msgspec.json.encode(reply), indent=1))

    @contextlib.contextmanager
    def asking(self, key: str) -> Iterator[UnderWay]:
        """Lock a request: others wait until its reply is there, or its sender stops.

        The caller checks again for a reply after it gets the lock. A record written by :meth:`note`
        remains for the next process, should this program be killed.
        """
        marker = self._marker(key)
        marker.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(marker, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            if fcntl is not None:
                fcntl.flock(descriptor, fcntl.LOCK_EX)
            try:
                state = msgspec.json.decode(marker.read_bytes(), type=UnderWay)
            except (OSError, msgspec.MsgspecError):
                state = UnderWay()
            yield state
            if self._reply(key).exists():  # else others may be waiting for this very file
                marker.unlink(missing_ok=True)
        finally:
            os.close(descriptor)

    def note(self, key: str, known: UnderWay) -> None:
        """Record the state of a request, before it is sent and after it fails."""
        descriptor = os.open(self._marker(key), os.O_CREAT | os.O_WRONLY | os.O_TRUNC, 0o600)
        with os.fdopen(descriptor, "wb") as file:
            file.write(msgspec.json.encode(known))
            file.flush()
            os.fsync(file.fileno())

    def used(self, run: str, purpose: str, key: str, origin: Origin) -> None:
        """Note that a run has used a reply; processes may do so at the same time."""
        path = self.path / "runs" / f"{run}-{purpose}.log"
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab") as file:  # one short line, which the system adds in one piece
            file.write(f"{key} {origin}\n".encode())

    def used_by(self, run: str, purpose: str) -> dict[str, Origin]:
        """Return the requests that a run has used, with the origins of their replies."""
        result: dict[str, Origin] = {}
        path = self.path / "runs" / f"{run}-{purpose}.log"
        lines = path.read_text().split("\n") if path.exists() else []
        for key, origin in (line.split() for line in lines if line):
            result[key] = "new" if "new" in (origin, result.get(key)) else "kept"
        return result

    def _reply(self, key: str) -> Path:
        return self.path / key[:2] / f"{key}.json"

    def _marker(self, key: str) -> Path:
        return self.path / key[:2] / f"{key}.asked"


def open_folder(path: Path) -> ReplyFolder:
    """Open a folder for replies; create it if it is missing, and check that it is writable."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        if not os.access(path, os.W_OK):
            raise PermissionError(13, "permission denied")
    except OSError as error:
        raise CorpusError(
            f"replies can't be kept: {error.strerror}",
            where=str(path),
            fix="name another folder with --replies",
        ) from error
    return ReplyFolder(path)


def key_of(endpoint: str, request: dict[str, Any]) -> str:
    """Return the digest of a request to an endpoint."""
    content = msgspec.json.encode({"endpoint": endpoint, "request": request}, order="sorted")
    return hashlib.sha256(content).hexdigest()


def now() -> str:
    """Return the time in UTC, in ISO 8601."""
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="milliseconds")


KEY_VARIABLE = "CT_LLM_KEY"
"""The environment variable with the endpoint's key; local servers need none."""
MISSING = "the package openai isn't installed: pip install 'corpus-tools-g3[llm]'"
FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 30.0
MILLION = 1e6
CHARACTERS_A_TOKEN = 4
"""Assumed before anything is sent; endpoints count tokens in other ways."""
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
        Purpose of the request: ``plan``, ``parse`` or ``judge``.
    """
    request = _request(endpoint, messages, schema, purpose)
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


def forecast(
    endpoint: Endpoint,
    requests: Iterable[tuple[Sequence[Message], Mapping[str, Any]]],
    *,
    purpose: str,
    rounds: int,
) -> str:
    """State how many requests will be sent, and about what their prompts cost.

    Parameters
    ----------
    requests
        Messages with the schema of their reply, as :func:`ask` takes them.
    rounds
        Number of requests at most where replies are faulty.
    """
    every = {
        key_of(endpoint.url, request): request
        for messages, schema in requests
        for request in [_request(endpoint, messages, schema, purpose)]
    }
    new = [request for key, request in every.items() if endpoint.replies.reply(key) is None]
    if not new:
        return f"language model, {purpose}: all {len(every)} replies are kept"
    characters = sum(len(m["content"]) for request in new for m in request["messages"])
    tokens = round(characters / CHARACTERS_A_TOKEN)
    cost = f", ${tokens * endpoint.price[0] / MILLION:.4f}" if endpoint.price else ""
    return (
        f"language model, {purpose}: {len(new)} requests to {endpoint.url} "
        f"({len(every) - len(new)} replies are kept), at most {rounds * len(new)} where replies "
        f"are faulty; about {tokens} tokens of prompts{cost}, and replies"
    )


def _request(
    endpoint: Endpoint, messages: Sequence[Message], schema: Mapping[str, Any], purpose: str
) -> dict[str, Any]:
    return {
        "model": endpoint.model,
        "messages": list(messages),
        "temperature": endpoint.temperature,
        "seed": endpoint.seed,
    } | _form(endpoint.form, purpose, dict(schema))


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
    message = body.get("message") if isinstance(body, dict) else body
    return str(message or error.message)[:300]


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


def usage(endpoint: Endpoint, purpose: str) -> Mapping[str, object]:
    """Return the usage behind the replies that a run has used.

    Parameters
    ----------
    purpose
        ``plan``, ``parse`` or ``judge``.

    Returns
    -------
    Mapping
        Numbers of ``requests`` with a reply, of ``new`` ones, and of those ``kept`` from before;
        ``sent``, the number of times these were sent in all, and of these ``in_doubt``, which may
        have been paid for without a reply. Tokens of prompts and completions; ``dollars``, of all
        replies and of the new ones, None without a price; seconds to a reply.
    """
    origins = endpoint.replies.used_by(endpoint.run, purpose)
    known = {key: reply for key in origins if (reply := endpoint.replies.reply(key))}
    replies = list(known.values())
    fresh = [reply for key, reply in known.items() if origins[key] == "new"]
    took = np.array([reply.latency_s for reply in replies]) if replies else np.full(1, np.nan)

    def dollars(some: list[KeptReply]) -> float | None:
        if endpoint.price is None:
            return None
        prompt, completion = endpoint.price
        cost = sum(r.tokens.prompt * prompt + r.tokens.completion * completion for r in some)
        return round(cost / MILLION, 6)

    return {
        "requests": len(replies),
        "new": len(fresh),
        "kept": len(replies) - len(fresh),
        "sent": sum(reply.tries for reply in replies),
        "in_doubt": sum(reply.in_doubt for reply in replies),
        "prompt_tokens": sum(reply.tokens.prompt for reply in replies),
        "completion_tokens": sum(reply.tokens.completion for reply in replies),
        "dollars": dollars(replies),
        "new_dollars": dollars(fresh),
        "latency_s": {
            "median": round(float(np.median(took)), 3),
            "p95": round(float(np.percentile(took, 95)), 3),
        },
        "models": sorted({reply.model for reply in replies}),
        "fingerprints": sorted({r.fingerprint for r in replies if r.fingerprint}),
    }


def in_words(purpose: str, told: Mapping[str, Any]) -> str:
    """State a usage in one line."""
    latency, cost, doubt = told["latency_s"], "", ""
    if told["dollars"] is not None:
        cost = f", ${told['dollars']:.4f} (${told['new_dollars']:.4f} now)"
    if told["in_doubt"]:
        doubt = f"; {told['in_doubt']} may have been paid for without a reply"
    return (
        f"language model, {purpose}: {told['requests']} requests ({told['kept']} kept from "
        f"before), {told['prompt_tokens']} + {told['completion_tokens']} tokens{cost}, "
        f"{latency['median']} s median, {latency['p95']} s p95{doubt}"
    )
