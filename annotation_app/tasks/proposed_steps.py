"""Steps that a model proposed for an episode: who sees whose, and what people made of them.

An item's payload has ``"proposed": {source: [[start_s, text]]}``, from the study's table. A
suggestion is ``{"source", "steps": [{"start_s", "text"}], "duration_s", "fps"}``. What became of
each proposed step is found by comparing it with the answer (:mod:`.step_alignment`); an answer only
says which of the steps were accepted as they are (``"decided"``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import watched
from annotation_app.items.new_items import draws
from annotation_app.store.models import Handout, Item, Record, Study
from annotation_app.studies.study_file import restored
from annotation_app.tasks.step_alignment import (
    Step,
    aligned,
    cut_likeness,
    steps_from,
    text_distance,
)
from annotation_app.tasks.task_record import Suggestion
from corpus_tools.episodes.step_errors import BOTH, BOUNDARY, REMOVED, TEXT, UNCHANGED

PROPOSED = "proposed"
SAME_S = 0.02
"""Largest difference of beginnings that are the same where frames have no constant rate."""


def suggested_steps(session: Session, item: Item) -> Suggestion | None:
    """Return the proposal of the source that the fewest people have been offered for an item.

    The first is drawn from the study's seed and the item's id.
    """
    proposed = item.payload.get(PROPOSED)
    if not proposed:
        return None
    offers = session.scalars(select(Handout.offer).where(Handout.item_id == item.id))
    had = Counter(
        offer["suggestion"]["source"] for offer in offers if offer and offer["suggestion"]
    )
    config = restored(session.get_one(Study, item.study_id).config)
    order = draws(config, f"model for {item.id}").permutation(sorted(proposed)).tolist()
    source = min(order, key=lambda name: had[name])
    film = watched(session, item)
    duration_s, fps = float(film["duration_s"]), film["fps"]
    steps = [
        {"start_s": start_s, "text": text}
        for start_s, text in placed_steps(proposed[source], duration_s, fps)
    ]
    if not steps:
        return None
    return Suggestion({"source": source, "steps": steps, "duration_s": duration_s, "fps": fps})


def placed_steps(
    steps: Sequence[Sequence[float | str]], duration_s: float, fps: float | None
) -> list[tuple[float, str]]:
    """Return a model's steps as people can have them: each begins on a frame of its own.

    The first begins with the video. Steps that would begin after its end are left out.
    """
    frame_s = 1.0 / fps if fps else SAME_S
    placed: list[tuple[float, str]] = []
    frame = -1
    for start_s, text in sorted((float(start), str(text)) for start, text in steps):
        frame = max(round(start_s / frame_s), frame + 1) if placed else 0
        if frame * frame_s < duration_s - frame_s / 2:
            placed.append((round(frame * frame_s, 3), text))
    return placed


def step_likeness(suggestion: Record, body: Record) -> float:
    """Return the likeness of an answer to a proposal, from 0 to 1: 1 if it is unchanged."""
    return cut_likeness(*_cuts(suggestion, body))


def step_fates(suggestion: Record, body: Record) -> Record:
    """Return what became of each proposed step in an answer, and which of its steps are new.

    Returns
    -------
    Record
        ``"source"``; ``"steps"``: for each proposed step its text, its ``state``, whether the
        person ``decided`` on it, the number of the answer's ``step`` or None, ``moved_s`` and
        ``text_distance``; ``"added"``: numbers of the answer's other steps.
    """
    proposed, answered = _cuts(suggestion, body)
    kept = {pair.one: pair.other for pair in aligned(proposed, answered)}
    decided = set(body.get("decided", ()))
    steps = []
    for number, step in enumerate(proposed):
        place = kept.get(number)
        fate = _fate(step, None if place is None else answered[place], suggestion["fps"])
        if place is None or number in decided or fate["state"] != UNCHANGED:
            fate["decided"] = True
        steps.append({"start_s": step.start_s, "text": step.text, "step": place, **fate})
    used = set(kept.values())
    added = [number for number in range(len(answered)) if number not in used]
    return {"source": suggestion["source"], "steps": steps, "added": added}


def _fate(proposed: Step, answered: Step | None, fps: float | None) -> Record:
    if answered is None:
        return {"state": REMOVED, "decided": False}
    moved_s = answered.start_s - proposed.start_s
    # The first step of a video begins with it, whoever cut it.
    is_first = not (proposed.start_s and answered.start_s)
    is_moved = not is_first and abs(moved_s) > (0.5 / fps if fps else SAME_S)
    distance = text_distance(proposed.text, answered.text)
    state = {
        (False, False): UNCHANGED, (True, False): TEXT, (False, True): BOUNDARY,
    }.get((distance > 0, is_moved), BOTH)  # fmt: skip
    return {
        "state": state,
        "decided": False,
        "moved_s": None if is_first else round(moved_s, 3),
        "text_distance": round(distance, 4),
    }


def _cuts(suggestion: Record, body: Record) -> Iterator[list[Step]]:
    for cut in (suggestion["steps"], body["subtasks"]):
        starts = [(float(step["start_s"]), str(step["text"])) for step in cut]
        yield steps_from(starts, suggestion["duration_s"], suggestion["fps"])
