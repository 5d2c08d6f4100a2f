"""Which things of a world an OBJECT's words allow: all that its noun fits and its modifiers do too.

A modifier that can't be measured (what is "safe") allows only the annotated thing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from eval.judging.layout import is_between, looking_at, nearest, seen
from eval.judging.worded import Worded
from g3.actions.grounding_candidates import carrier
from g3.actions.logged_actions import centre
from g3.groundings import FloatArray, Prism
from g3.inference.problem.phrases import is_area, is_pronoun, told
from g3.language.discourse.negation import negated
from g3.language.lexicon.concepts import Concept, concepts
from g3.language.lexicon.field_words import bare, field_words, normalise
from g3.language.lexicon.word_sets import EMPTY, ORDINALS, SELVES, stems
from g3.sdc.clauses import SDC, Span

BESIDE_M = 4.0
"""What is next to a thing is no further from its border."""
NEAR_M = 6.0
"""What is near a thing, or before or behind it, is no further from its border."""
AHEAD = np.pi / 3
"""What is in front of somebody is no further off the way that they look."""
ASIDE = np.pi / 12
"""What is to the left or the right of somebody is at least so far off it."""

TOWARD = stems("toward towards")
"""What goes somewhere needn't stand there."""
_ORDINALS = {normalise(word): number for word, number in ORDINALS.items()}
_EXTREMES = frozenset(
    normalise(w) for w in ("leftmost", "left-most", "rightmost", "right-most", "all", "outside")
)


@dataclass(frozen=True, slots=True)
class _Modifier:
    words: tuple[str, ...]
    landmarks: tuple[int, ...] = ()
    negative: bool = False

    @property
    def concepts(self) -> frozenset[Concept]:
        return concepts(self.words)

    @property
    def side(self) -> Concept | None:
        sides: set[Concept] = {"left", "right"}
        found = sorted(sides & self.concepts)
        return found[0] if len(found) == 1 else None

    @property
    def ordinal(self) -> int | None:
        """Its place in an order; 1 from that side for what is the leftmost."""
        number = next((_ORDINALS[w] for w in self.words if w in _ORDINALS), None)
        extreme = _EXTREMES.intersection(self.words) or {"last", "far", "first"} & self.concepts
        return number or (1 if self.side and extreme else None)


def allowed(words: Worded, node: int, also: tuple[Span, ...] = ()) -> frozenset[str]:
    """Ids of the things that an OBJECT's words allow; none if it is grounded in none.

    Parameters
    ----------
    words
        The command in a world. In its own the annotated things are always allowed.
    node
        The OBJECT.
    also
        Words elsewhere that tell more of it: "from the right".
    """
    annotated = words.things[node]
    if not annotated or words.robot in annotated or is_pronoun(words.tree.nodes[node]):
        return annotated
    found, known = words.alike(node), True
    modifiers = list(_modifiers(words, node))
    if also:
        modifiers.append(_Modifier(told(field_words(also))))
    order = [m for m in modifiers if m.side or m.ordinal]
    modifiers = [m for m in modifiers if m not in order]
    if order:
        # "The second pallet" "from the right" are one modifier in two places.
        modifiers.append(
            _Modifier(
                tuple(w for m in order for w in m.words),
                tuple(n for m in order for n in m.landmarks),
            )
        )
    for modifier in modifiers:
        fitting = _fitting(words, node, modifier, found)
        known &= fitting is not None
        found = found if fitting is None else fitting
    if words.own:
        return annotated | found if known else annotated
    return found if known else found & annotated


def unplaced(words: Worded, marks: Iterable[int]) -> tuple[str, ...]:
    """Words of landmarks that are no things, which say where as relations do: "the middle"."""
    leaves = (n for n in marks if not words.labels[n] and words.tree.nodes[n].is_leaf)
    return tuple(w for n in leaves for w in told(field_words(words.tree.nodes[n].words)))


def prisms(words: Worded, ids: frozenset[str]) -> list[Prism]:
    """Where things are before anything is done."""
    return [words.state.thing(i).prism for i in sorted(ids)]


def _modifiers(words: Worded, node: int) -> Iterator[_Modifier]:
    tree = words.tree
    sdc: SDC | None = tree.nodes[node]
    while sdc is not None:
        here = tree.children[node]
        marks = tuple(n for f in ("l", "l2") for n in here.get(f, ()))
        same = marks and all(
            words.things[n] == words.things[node] and not _reflexive(tree.nodes[n]) for n in marks
        )
        spoken = told(field_words(sdc.relation if sdc.figure else sdc.words))
        spoken += unplaced(words, marks)
        way = TOWARD.intersection(spoken) and not marks
        if not (same and words.things[node]) and not way:
            yield _Modifier(spoken, marks, negated(sdc))
        node = next((n for n in here.get("f", ()) if tree.nodes[n].type == "OBJECT"), -1)
        sdc = tree.nodes[node] if node >= 0 else None


def _reflexive(sdc: SDC) -> bool:
    return any(bare(word.text) in SELVES for word in sdc.words)


def _fitting(
    words: Worded, node: int, modifier: _Modifier, found: frozenset[str]
) -> frozenset[str] | None:
    """The things that a modifier fits; None if it can't be measured."""
    named, marks = modifier.concepts, modifier.landmarks
    objects = [n for n in marks if words.tree.nodes[n].type == "OBJECT"]
    if modifier.negative or len(objects) < len(marks):
        return None if named or modifier.negative else found
    if any(words.labels[n] and not words.things[n] for n in objects):
        return frozenset()
    landmarks = frozenset(i for n in objects if n != node for i in allowed(words, n))
    of_robot = not landmarks or landmarks == {words.robot}
    if modifier.side or modifier.ordinal:
        group = landmarks - {words.robot}
        return _in_order(words, modifier, found, group)
    if any(is_area(words.tree.nodes[n]) for n in objects) and "on" in named:
        return frozenset(i for i in found if carrier(words.state, i) is None)
    if EMPTY.intersection(modifier.words):
        laden = {c.id for o in words.state.context.objects if (c := carrier(words.state, o.id))}
        return found - laden
    if any(_reflexive(words.tree.nodes[n]) for n in objects):
        return _alone(words, found)
    if objects and not landmarks and not named & {"between"}:
        return None if named else found
    if "between" in named:
        return _amid(words, found, landmarks)
    if {"front", "back"} & named and of_robot:
        return _before(words, found, behind="back" in named)
    if "on" in named and landmarks:
        return frozenset(i for i in found if _stands_on(words, i, landmarks))
    if named & {"near", "front", "back"} and landmarks:
        reach = BESIDE_M if "near" in named else NEAR_M
        around = prisms(words, landmarks)
        return frozenset(
            i for i in found if i not in landmarks and nearest(words.state.thing(i).prism, around) <= reach
        )
    if named & {"near", "far"}:
        return _by_distance(words, found, far="far" in named)
    if of_robot and landmarks:
        return _before(words, found, behind=False)
    return found if not landmarks else None


def _stands_on(words: Worded, thing: str, carriers: frozenset[str]) -> bool:
    if words.robot in carriers:
        return words.state.held == thing
    under = carrier(words.state, thing)
    return under is not None and under.id in carriers


def _in_order(
    words: Worded, modifier: _Modifier, found: frozenset[str], group: frozenset[str]
) -> frozenset[str]:
    """Those on a side, or the so many-th from it, among all things alike or those of a group."""
    state, side, number = words.state, modifier.side, modifier.ordinal
    among = found
    on = frozenset(i for i in found if (c := carrier(state, i)) and c.id in group)
    if on:
        among = on
    elif group & found:
        among = found & group
    elif group:
        around = prisms(words, group)
        among = frozenset(i for i in found if nearest(words.state.thing(i).prism, around) <= NEAR_M)
        return frozenset(i for i in among if side and _is_beside(words, i, group, side))
    counted = among
    if number and not group:
        # "The third pallet" may count pallets of other kinds in the row, too.
        counted = _peers(words, among)
    sets = [*_together(words, among), *_together(words, counted)]
    fitting: set[str] = set()
    for several in sets:
        ids = _from_left(words, several)
        for a, i in enumerate(ids, start=1):
            b = len(ids) + 1 - a
            places = {"left": (a,), "right": (b,)}.get(side or "", (a, b))
            half = len(ids) == 1 or places[0] < (len(ids) + 1) / 2
            if number in places or (number is None and half):
                fitting.add(i)
    if number is None and side and not group:
        fitting |= {i for i in found if _is_aside(state.pose, words, i, side)}
    return frozenset(fitting) & found


def _is_aside(pose: FloatArray, words: Worded, thing: str, side: Concept) -> bool:
    [[ahead, left]] = seen(pose, centre(words.state.thing(thing).prism)[None])
    angle = float(np.arctan2(left, ahead))
    return (angle if side == "left" else -angle) >= ASIDE


def _is_beside(words: Worded, thing: str, group: frozenset[str], side: Concept) -> bool:
    points = np.array([centre(p) for p in prisms(words, group)])
    own = centre(words.state.thing(thing).prism)
    view = looking_at(words.state.pose, points)
    left = float(seen(view, own[None])[0, 1] - seen(view, points)[:, 1].mean())
    return left > 0 if side == "left" else left < 0


def _alone(words: Worded, found: frozenset[str]) -> frozenset[str]:
    """The one furthest from all others."""
    gaps = {
        i: nearest(words.state.thing(i).prism, prisms(words, _peers(words, found) - {i}))
        for i in found
    }
    return frozenset(i for i in found if gaps[i] == max(gaps.values()))


def _amid(words: Worded, found: frozenset[str], landmarks: frozenset[str]) -> frozenset[str] | None:
    """Those between landmarks; without any those that aren't at an end."""
    if landmarks:
        ends = prisms(words, landmarks)
        return frozenset(i for i in found if is_between(words.state.thing(i).prism, ends))
    inner = [_from_left(words, ids)[1:-1] for ids in _together(words, _peers(words, found))]
    return found & frozenset(i for ids in inner for i in ids)


def _from_left(words: Worded, ids: frozenset[str]) -> list[str]:
    """Things in their order from left to right for who looks at them."""
    order = sorted(ids)
    if not order:
        return []
    points = np.array([centre(words.state.thing(i).prism) for i in order])
    leftward = seen(looking_at(words.state.pose, points), points)[:, 1]
    return [order[i] for i in np.argsort(-leftward, kind="stable")]


def _together(words: Worded, ids: frozenset[str]) -> list[frozenset[str]]:
    """Those that stand on the same thing, or on the ground; all of them if none would be left."""
    by: dict[str, set[str]] = {}
    for i in ids:
        under = carrier(words.state, i)
        by.setdefault(under.id if under else "", set()).add(i)
    several = [frozenset(own) for own in by.values() if len(own) > 1]
    return several or [ids]


def _peers(words: Worded, found: frozenset[str]) -> frozenset[str]:
    """Things that share a label with some of those found, and these."""
    known = {label for i in found for label in words.state.thing(i).labels}
    things = words.state.context.objects
    return frozenset(o.id for o in things if o.id != words.robot and known & set(o.labels))


def _before(words: Worded, found: frozenset[str], *, behind: bool) -> frozenset[str]:
    """The nearest or the straightest in front of the robot, or behind it; what it holds, too."""
    ids = sorted(found)
    if not ids:
        return found
    points = np.array([centre(words.state.thing(i).prism) for i in ids])
    place = seen(words.state.pose, points) * (-1 if behind else 1)
    off = np.abs(np.arctan2(place[:, 1], place[:, 0]))
    away = np.linalg.norm(place, axis=1)
    there = off <= AHEAD
    best = {i for i, t in zip(ids, there, strict=True) if t} & {
        ids[int(np.argmin(off))],
        ids[int(np.argmin(np.where(there, away, np.inf)))],
    }
    return frozenset(best | ({words.state.held} & found if words.state.held else set()))


def _by_distance(words: Worded, found: frozenset[str], *, far: bool) -> frozenset[str]:
    start = words.state.pose[:2]
    away = {i: float(np.linalg.norm(centre(words.state.thing(i).prism) - start)) for i in found}
    best = (max if far else min)(away.values(), default=0.0)
    return frozenset(i for i in found if away[i] == best)
