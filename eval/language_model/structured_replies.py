"""Structured replies: read by msgspec, checked, and requested again where they can't be used."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeVar

import msgspec

from eval.language_model.chat_endpoint import Endpoint, Message, ask
from g3.errors import CorpusError, FormatError

Form = TypeVar("Form", bound=msgspec.Struct)
Value = TypeVar("Value")

ROUNDS = 3
"""Number of requests for one reply; each states the error of the one before."""
SHOWN = 200


class UnusableReplyError(CorpusError):
    """A language model has given no reply that can be used."""


def ask_for(
    endpoint: Endpoint,
    messages: Sequence[Message],
    form: type[Form],
    use: Callable[[Form], Value],
    *,
    purpose: str,
    choices: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> Value:
    """Ask for a reply in a form, and convert it.

    Parameters
    ----------
    use
        Converts the reply; raises a FormatError where that can't be done.
    choices
        Allowed values of the form's fields, by name, for servers that constrain a model to them.

    Raises
    ------
    UnusableReplyError
        If no reply can be used.
    CorpusError
        If the endpoint gives no reply.
    """
    said, schema = list(messages), _schema(form, choices)
    problem = ""
    for _ in range(ROUNDS):
        reply = ask(endpoint, said, schema, purpose=purpose)
        try:
            return use(msgspec.json.decode(json_in(reply.text), type=form))
        except (FormatError, msgspec.MsgspecError, RecursionError) as error:
            problem = str(error)
        said += [
            {"role": "assistant", "content": reply.text},
            {
                "role": "user",
                "content": f"That can't be used: {problem}. Give the whole JSON again.",
            },
        ]
    raise UnusableReplyError(f"no reply of the language model can be used: {problem[:SHOWN]}")


def _schema(form: type[msgspec.Struct], choices: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return the JSON Schema of a form: an object at the top, for endpoints, without prose."""
    whole = msgspec.json.schema(form)
    root = whole["$defs"].pop(form.__name__)
    bare: dict[str, Any] = _without_prose({**root, "$defs": whole["$defs"]})
    for part in (bare, *bare["$defs"].values()):
        for name in part.get("properties", {}).keys() & choices.keys():
            part["properties"][name] |= {"enum": list(choices[name])}
    return bare


def _without_prose(part: Any) -> Any:
    if isinstance(part, dict):
        kept = ((k, v) for k, v in part.items() if k not in ("title", "description"))
        return {key: _without_prose(value) for key, value in kept}
    return [_without_prose(item) for item in part] if isinstance(part, list) else part


def json_in(text: str) -> str:
    """Return the JSON object in a reply, without the text that models put around it.

    >>> json_in('Sure: {"correct": true}!')
    '{"correct": true}'
    """
    first, last = text.find("{"), text.rfind("}")
    return text[first : last + 1] if 0 <= first < last else text
