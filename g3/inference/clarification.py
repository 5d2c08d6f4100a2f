"""Questions back: which thing is meant, where the plans that are about as good disagree."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from g3.actions.grounding_candidates import beneath
from g3.actions.robot_state import State
from g3.errors import AnswerError
from g3.geometry.footprints import centre
from g3.geometry.relations import in_frame
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.grounding_problem import Candidate
from g3.inference.problem.phrases import is_pronoun
from g3.inference.search.action_search import Choices, Hypothesis
from g3.language.discourse.groups import Group, group, noun_leaf
from g3.language.lexicon.field_words import bare, text_words
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.sdc.clauses import SDC, all_words
from g3.short_repr import short_repr

Things = Callable[[Sequence[SDC], int, tuple[str, ...]], Sequence[Candidate]]
"""Function from clauses, an OBJECT's node and ids of objects to the OBJECT's groundings in these
objects, the best first."""
SURE = 0.6
"""Least share of the best object among those that an answer may mean."""
UNSURE_NATS = 0.5
"""Smallest entropy over a clause's candidate objects that leads to a question."""
LIKELY = 0.1
"""Objects with a smaller share are not offered."""


@short_repr
@dataclass(frozen=True, slots=True)
class Question:
    """A choice between several objects that a clause may mean.

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


def question_about(
    tree: Tree, plan: Hypothesis, start: State, answered: Collection[int] = ()
) -> Question | None:
    """Return the question about the least sure clause of a plan; None if it is sure enough.

    Nothing is asked about what is answered.
    """
    best: tuple[float, int, dict[str, float]] | None = None
    for node, choices in sorted(plan.choices.items()):
        sdc = tree.nodes[node]
        if sdc.type != "OBJECT" or node in answered or is_pronoun(sdc):
            continue
        shares = thing_shares(choices)
        p = np.array(list(shares.values()))
        entropy = float(-(p * np.log(np.maximum(p, 1e-12))).sum())
        if entropy > UNSURE_NATS and (best is None or entropy > best[0]):
            best = (entropy, node, shares)
    return None if best is None else _asked(tree, best[1], best[2], start)


def thing_shares(choices: Choices) -> dict[str, float]:
    """Divide the probability of a clause among the single things that it may mean.

    Empty if it rather means several.
    """
    single = {g[0].id: s for g, s in choices if len(g) == 1 and isinstance(g[0], PhysicalObject)}
    if len(choices[0][0]) != 1 or not single:
        return {}
    return dict(zip(single, softmax(list(single.values())).tolist(), strict=True))


def _asked(tree: Tree, node: int, shares: dict[str, float], start: State) -> Question | None:
    likely = sorted((i for i, p in shares.items() if p >= LIKELY), key=lambda i: -shares[i])
    if len(likely) < 2:
        return None
    words = " ".join(word.text for word in all_words(tree.nodes[node]))
    options = tuple(zip(likely, told_apart(start, likely), strict=True))
    *first, last = (text for _, text in options)
    listed = f"{', '.join(first)} or {last}"
    return Question(node, f'Which one is "{words}": {listed}?', options)


def understood(question: Question, clause: SDC, reply: str, things: Things) -> tuple[str, ...]:
    """Return the objects that an answer means: one, several, or none of the options.

    An option's number and its own words mean it. Other answers are OBJECTs, grounded as in a
    command, in the options alone; where they have no noun, it is that of the clause.

    Parameters
    ----------
    question
        The question.
    clause
        The clause that it asks about.
    reply
        The answer.
    things
        How OBJECTs are grounded.

    Raises
    ------
    AnswerError
        If the answer picks out none of the options.
    """
    ids = tuple(name for name, _ in question.options)
    words = text_words(reply)
    is_opposite = words[:1] == ("not",)
    words = words[is_opposite:]
    chosen = _listed(question, words)
    if chosen is None:
        noun = (noun_leaf(clause).words or all_words(clause))[-1]
        chosen = _picked(words, ids, bare(noun.text), things)
    if chosen is not None and is_opposite:
        # "Not both" leaves open which one.
        chosen = tuple(name for name in ids if name not in chosen) or None
    if chosen is None:
        listed = "; ".join(f"{n}. {text}" for n, (_, text) in enumerate(question.options, start=1))
        raise AnswerError(
            f"{reply!r} doesn't pick out one of them", fix=f"say its number or its place: {listed}"
        )
    return chosen


def _listed(question: Question, words: Sequence[str]) -> tuple[str, ...] | None:
    """Return the options that an answer means without a look at the world; None if it must."""
    ids = tuple(name for name, _ in question.options)
    content = [word for word in words if word not in WORDS["listing"]]
    count = {COUNTS["counts"].get(word, len(ids)) for word in content}
    if len(content) == 1:
        numbers = (
            COUNTS["cardinals"]
            if len(words) > 1 and words[0] in WORDS["option"]
            else COUNTS["ordinals"]
        )
        place = numbers.get(content[0], int(content[0]) if content[0].isdecimal() else 0)
        if place:
            return ids[place - 1 : place] if 0 < place <= len(ids) else None
    if content and WORDS["none_of_them"].issuperset(content):
        return ()
    if content and WORDS["whichever"].issuperset(content):
        return ids[:1]
    if (
        content
        and count == {len(ids)}
        and WORDS["universal"].union(COUNTS["counts"]).issuperset(content)
    ):
        return ids
    same = [name for name, text in question.options if text_words(text) == tuple(words)]
    return tuple(same) if len(same) == 1 else None


def _picked(
    words: Sequence[str], ids: tuple[str, ...], noun: str, things: Things
) -> tuple[str, ...] | None:
    from g3.language.parsing.parser import parse  # noqa: PLC0415 - slow to import

    named = [noun if word in WORDS["ones"] else word for word in words]
    if not any(word in {*WORDS["ones"], noun} for word in words):
        is_place = any(word in WORDS["place_prepositions"] for word in words[:1])
        named = ["the", noun, *words] if is_place else [*words, noun]
    sdcs = parse(f"pick up {' '.join(named)}").sdcs
    bare_sdcs = parse(f"pick up the {noun}").sdcs
    tree = Tree(sdcs)
    nouns = _objects(Tree(bare_sdcs))[:1]
    before = _singles([c for node in nouns for c in things(bare_sdcs, node, ids)])
    found: dict[str, None] = {}
    for node in _objects(tree):
        best = _best(_singles(things(sdcs, node, ids)), before, group(tree.nodes[node]))
        if not best:
            return None
        found |= dict.fromkeys(best)
    return tuple(found) or None


def _objects(tree: Tree) -> list[int]:
    """Return the OBJECTs that are in no other one."""
    objects = [n for n, sdc in enumerate(tree.nodes) if sdc.type == "OBJECT" and all_words(sdc)]
    inner = {n for node in objects for n in tree.all_below(node)[1:]}
    return [n for n in objects if n not in inner and not is_pronoun(tree.nodes[n])]


def _singles(beam: Sequence[Candidate]) -> dict[str, float]:
    """Return the best score of each single object."""
    singles: dict[str, float] = {}
    for candidate in beam:
        if len(candidate.group) == 1 and isinstance(candidate.group[0], PhysicalObject):
            singles.setdefault(candidate.group[0].id, candidate.score)
    return singles


def _best(scores: Mapping[str, float], before: Mapping[str, float], said: Group) -> tuple[str, ...]:
    """Return the objects that words speak for, beside the noun alone; none if that isn't clear."""
    gains = {name: score - before[name] for name, score in scores.items() if name in before}
    count = (said.count or 1) if said.number == "plural" else 1
    if len(gains) < count:
        return ()
    order = sorted(gains, key=lambda name: -gains[name])
    shares = softmax([gains[name] for name in order])
    return tuple(order[:count]) if shares[:count].sum() >= SURE else ()


def told_apart(state: State, object_ids: Sequence[str]) -> list[str]:
    """Describe objects in words by their largest difference: position, or else order.

    Things on different sides, or on different things, are named by that alone; others by which is
    further left or nearer.
    """
    where = [_where(state, i) for i in object_ids]
    texts = [f"the one {place}" for place in where]
    for place in dict.fromkeys(where):
        same = [n for n, other in enumerate(where) if other == place]
        if len(same) > 1:
            orders = _orders(np.array([_from_robot(state, object_ids[n]) for n in same]))
            for n, order in zip(same, orders, strict=True):
                texts[n] = f"the {order} one {place}"
    return texts


def _orders(points: FloatArray) -> list[str]:
    """Order points (n, 2) in the robot's frame: left or right, near or far."""
    away = np.linalg.norm(points, axis=1)
    angle = np.arctan2(points[:, 1], points[:, 0])
    middle = np.arctan2(np.sin(angle).sum(), np.cos(angle).sum())
    # Left and right are those of who faces the things.
    leftward = points[:, 1] * np.cos(middle) - points[:, 0] * np.sin(middle)
    across = np.ptp(leftward) >= np.ptp(away)
    order = np.argsort(-leftward if across else away, kind="stable")
    first, last = ("left", "right") if across else ("near", "far")
    counted = ["first", "second", "third", "fourth", "fifth", "sixth"]
    if len(points) < 4:
        names = [first, "middle", last] if len(points) == 3 else [first, last]
    else:
        side = "from the left" if across else "from you"
        names = [f"{counted[min(n, 5)]} {side}" for n in range(len(points))]
    found = [""] * len(points)
    for name, n in zip(names, order, strict=True):
        found[n] = name
    return found


def _where(state: State, object_id: str) -> str:
    """Locate an object: on another, or on which side of the robot."""
    if object_id == state.held:
        return "on your forks"
    under = beneath(Place(state.thing(object_id).prism), state, object_id)
    if under is not None:
        return f"on the {' '.join(under.labels)}"
    x, y = _from_robot(state, object_id)
    sides = ["ahead of you", "to your left", "behind you", "to your right"]
    return sides[int(np.round(np.arctan2(y, x) / (np.pi / 2))) % 4]


def _from_robot(state: State, object_id: str) -> FloatArray:
    """Return an object's middle in the robot's frame, shape (2,)."""
    middle = centre(state.thing(object_id).prism)
    return in_frame(middle, state.pose)
