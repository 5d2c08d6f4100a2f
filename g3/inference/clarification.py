"""Questions back: which thing is meant, where the plans that are about as good disagree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions import centre
from g3.geometry import rotate
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.candidates import beneath
from g3.inference.search import Hypothesis
from g3.inference.state import State
from g3.inference.things import Tree, is_pronoun
from g3.sdc import all_words

UNSURE_NATS = 0.5
"""Entropy over the objects that a clause may mean from which on it is asked."""
LIKELY = 0.1
"""Objects with a smaller share are not offered."""


@dataclass(frozen=True, slots=True)
class Question:
    """Which of several objects a clause means.

    Parameters
    ----------
    node
        The clause.
    text
        The question.
    options
        Ids of the objects and how the question calls them.
    """

    node: int
    text: str
    options: tuple[tuple[str, str], ...]


def question_about(tree: Tree, beam: Sequence[Hypothesis], start: State) -> Question | None:
    """The question about the clause of which the beam is least sure; None if it is sure enough."""
    score = np.array([h.score for h in beam])
    share = np.exp(score - score.max())
    share /= share.sum()
    best: tuple[float, int, dict[str, float]] | None = None
    for node, sdc in enumerate(tree.nodes):
        if sdc.type != "OBJECT" or is_pronoun(sdc):
            continue
        shares: dict[str, float] = {}
        for h, part in zip(beam, share, strict=True):
            group = h.nodes[node][0] if node in h.nodes else ()
            if len(group) == 1 and isinstance(group[0], PhysicalObject):
                shares[group[0].id] = shares.get(group[0].id, 0.0) + float(part)
        p = np.array(list(shares.values()))
        entropy = float(-(p * np.log(np.maximum(p, 1e-12))).sum())
        if len(shares) > 1 and entropy > UNSURE_NATS and (best is None or entropy > best[0]):
            best = (entropy, node, shares)
    return None if best is None else _asked(tree, best[1], best[2], start)


def _asked(tree: Tree, node: int, shares: dict[str, float], start: State) -> Question | None:
    likely = sorted((i for i, p in shares.items() if p >= LIKELY), key=lambda i: -shares[i])
    if len(likely) < 2:
        return None
    words = " ".join(word.text for word in all_words(tree.nodes[node]))
    options = tuple(zip(likely, told_apart(start, likely), strict=True))
    listed = " or ".join(text for _, text in options)
    return Question(node, f'Which one is "{words}": {listed}?', options)


def told_apart(state: State, object_ids: Sequence[str]) -> list[str]:
    """Objects in words; those whose words are the same are told by where exactly they are."""
    texts = [described(state, i) for i in object_ids]
    return [
        text if texts.count(text) == 1 else f"{text} ({_exactly(state, i)})"
        for i, text in zip(object_ids, texts, strict=True)
    ]


def _exactly(state: State, object_id: str) -> str:
    x, y = _from_robot(state, object_id)
    along, aside = "ahead" if x >= 0 else "behind", "left" if y >= 0 else "right"
    return f"{abs(x):.1f} m {along}, {abs(y):.1f} m to the {aside}"


def _from_robot(state: State, object_id: str) -> FloatArray:
    """An object's middle in the robot's frame, shape (2,)."""
    middle = centre(state.thing(object_id).prism)
    return rotate(middle - state.pose[:2], -state.pose[2])


def described(state: State, object_id: str) -> str:
    """An object in words: what it stands on, or how it lies from the robot."""
    thing = state.thing(object_id)
    under = beneath(Place(thing.prism), state, object_id)
    if under is not None:
        return f"the one on the {' '.join(under.labels)}"
    x, y = _from_robot(state, object_id)
    where = ["ahead of you", "to your left", "behind you", "to your right"]
    quarter = int(np.round(np.arctan2(y, x) / (np.pi / 2))) % 4
    return f"the one {np.hypot(x, y):.0f} m {where[quarter]}"
