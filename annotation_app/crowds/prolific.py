"""Prolific's participants: ids in the address, and a completion code to go back with."""

from __future__ import annotations

import re
from collections.abc import Mapping
from urllib.parse import urlencode

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.crowds.platform import Arrival, Ending, Gateway, Platform
from annotation_app.store.models import Participation

NAME = "prolific"
COMPLETE = "https://app.prolific.com/submissions/complete"
ID = re.compile(r"[0-9A-Za-z]{1,64}")
PARAMETERS = ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")
QUERY = "&".join(f"{name}={{{{%{name}%}}}}" for name in PARAMETERS)
"""Query parameters that Prolific fills in."""


def enter(arguments: Mapping[str, str], _study_id: str) -> Arrival:
    """Read ``PROLIFIC_PID`` and ``SESSION_ID``, which is the submission's id."""
    person, _, submission = (arguments.get(name, "") for name in PARAMETERS)
    if not ID.fullmatch(person) or not ID.fullmatch(submission):
        raise Refusal(
            400, gettext("Prolific didn't say who you are. Open the study from Prolific again.")
        )
    return Arrival(NAME, person, submission)


def leave(_participation: Participation, code: str) -> Ending:
    """Return the link that completes the submission at Prolific."""
    return Ending(f"{COMPLETE}?{urlencode({'cc': code})}")


def connect(*, sandbox: bool, endpoint: str | None) -> Platform:
    """Open the researcher's interface."""
    from annotation_app.crowds.prolific_client import open_prolific  # noqa: PLC0415 - httpx

    return open_prolific(sandbox=sandbox, endpoint=endpoint)


PROLIFIC = Gateway(enter, leave, connect, query=QUERY)
