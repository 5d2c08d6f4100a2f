"""Links: open ones for anybody, and invitations for one person each."""

from __future__ import annotations

from collections.abc import Mapping

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.crowds.platform import Arrival, Ending, Gateway
from annotation_app.people.participants import INVITED, OPEN, read_invitation
from annotation_app.store.models import Participation

INVITATION = "invitation"
"""The argument of a link that holds an invitation."""


def enter(arguments: Mapping[str, str], study_id: str) -> Arrival:
    """Admit the invited person of a link, or anybody."""
    token = arguments.get(INVITATION)
    if token is None:
        return Arrival(OPEN, None, None)
    invited_to, digest = read_invitation(token)
    if invited_to != study_id:
        raise Refusal(404, gettext("This link is for another study."))
    return Arrival(INVITED, f"{study_id} {digest}", digest)


def leave(_participation: Participation, _code: str) -> Ending:
    """Return no exit: people are shown their code."""
    return Ending()


LINKS = Gateway(enter, leave)
