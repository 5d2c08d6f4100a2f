"""The part of a video that shows an EVENT or a PATH.

For a command of one step it is the whole video, unless somebody chooses a part. With several EVENTs
nothing is preset, or each of them would get the whole video by default. An answer keeps
``"trims"``: {node: [start_s, end_s]}, and ``"whole"``: {node: "chosen" or "preset"}, which says
whether somebody chose the whole video or left it so.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from annotation_app.core.languages import gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.store.models import Record
from annotation_app.tasks.clause_words import HAPPENING, phrase_of
from g3.sdc.clauses import SDC, breadth_first

SLACK_S = 0.5
"""Largest time by which a part may exceed a video's end, as players round, in seconds."""


def must_be_chosen(sdcs: tuple[SDC, ...]) -> Mapping[str, str]:
    """Return the nodes for which nothing is preset, and their words."""
    named = [(str(n), sdc) for n, sdc in enumerate(breadth_first(sdcs)) if not sdc.is_implicit]
    if sum(sdc.type == "EVENT" for _, sdc in named) < 2:
        return {}
    return {node: phrase_of(sdc) for node, sdc in named if sdc.type in HAPPENING}


def read_parts(
    sdcs: tuple[SDC, ...],
    trims: Mapping[str, tuple[float, float]],
    whole: Collection[str],
    duration_s: float,
) -> tuple[Record, list[FieldProblem]]:
    """Return a person's chosen parts in their kept form, and the faults of them.

    `whole` has the nodes for which the whole video was chosen, which has this duration.
    """
    known = _happening(sdcs)
    problems: list[FieldProblem] = []

    def refuse(node: str, message: str) -> None:
        problems.append(FieldProblem(node, message))

    for node, (start, end) in sorted(trims.items()):
        if node not in known:
            refuse(node, gettext("There is no such clause to trim."))
        elif not start < end <= duration_s + SLACK_S:
            refuse(node, gettext("The part of the video must begin before it ends."))
    for node in sorted(set(whole)):
        if node not in known:
            refuse(node, gettext("There is no such clause to trim."))
        elif node in trims:
            refuse(node, gettext("Choose either the whole video or a part of it."))
    for node, phrase in must_be_chosen(sdcs).items():
        if node not in trims and node not in whole:
            told = gettext("Choose which part of the video shows “%(phrase)s”.", phrase=phrase)
            refuse(node, told)
    left = [node for node in known if node not in trims]
    kept = {
        "trims": {node: list(trim) for node, trim in trims.items()},
        "whole": {node: "chosen" if node in whole else "preset" for node in left},
    }
    return kept, problems


def sent_parts(sdcs: tuple[SDC, ...], body: Record) -> Record:
    """Return the parts of a kept answer in the form in which a page sends them.

    Answers from before nodes could be chosen have no ``"whole"``: they mean the whole video.
    """
    trims = body["trims"]
    whole = body.get("whole", {n: "chosen" for n in _happening(sdcs) if n not in trims})
    return {"trims": trims, "whole": [node for node, how in whole.items() if how == "chosen"]}


def _happening(sdcs: tuple[SDC, ...]) -> list[str]:
    nodes = enumerate(breadth_first(sdcs))
    return [str(node) for node, sdc in nodes if sdc.type in HAPPENING]
