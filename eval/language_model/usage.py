"""A run's usage of a language model: requests, tokens, dollars, seconds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from eval.language_model.chat_endpoint import Endpoint
from eval.language_model.kept_replies import KeptReply

MILLION = 1e6


def usage(endpoint: Endpoint, purpose: str) -> Mapping[str, object]:
    """Return the usage behind the replies that a run has used.

    Parameters
    ----------
    purpose
        ``plan`` or ``judge``.

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
