"""People's language about episodes as JSON lines, for datasets of any format."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec

from annotation_app.export.lerobot_export import PeoplesLanguage


def language_lines(said: PeoplesLanguage) -> bytes:
    """Return a line for each text of people, then those of :attr:`PeoplesLanguage.files`.

    ``source`` is the episode's place in the dataset, ``step`` the number of the frame, and
    ``time_ns`` the moment by the recording's clock; each is null where it isn't known.
    """
    lines = msgspec.json.Encoder().encode_lines(list(_texts(said)))
    more = (content for name, content in said.files.items() if name.endswith(".jsonl"))
    return b"".join((lines, *more))


def _texts(said: PeoplesLanguage) -> Iterator[dict[str, Any]]:
    for index, added in said.language.items():
        about = said.episodes.get(index, {})
        rate, start = rate_of(about), str(about.get("start") or "")
        for item in added.said:
            time_ns = int(start) + round(item.start_s * 1e9) if start.isdecimal() else None
            yield {
                "episode_index": index,
                "source": about.get("source") or None,
                "style": item.style,
                "start_s": item.start_s,
                "step": round(item.start_s * rate) if rate else None,
                "time_ns": time_ns,
                "content": item.text,
                **item.of_event(),
                **item.source,
            }


def rate_of(about: Any) -> float:
    """Return the frames a second of an episode by its row of the study's table; 0 if unknown."""
    try:
        rate = float(about.get("fps") or 0)
    except (TypeError, ValueError):
        return 0.0
    return rate if 0 < rate < float("inf") else 0.0
