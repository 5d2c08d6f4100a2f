"""Clauses of a command that a tree has apart, though they are one.

"The drum" and "to the gate", "do not" and "lift it", and a subject that two clauses share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from g3.inference.problem.phrases import names_forks, names_robot, side_by_side
from g3.language.discourse.negation import is_negation, negated
from g3.language.lexicon.field_words import bare, normalise
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.word_sets import INTERJECTIONS, LEADING, WORD_CLASSES, words
from g3.sdc.clauses import SDC, Span
from g3.sdc.sdc_notation import IMPLICIT_FIGURE

_POLITE = words(WORD_CLASSES["polite"])
_JOINED = len(", ")
"""So far apart at most are two clauses with nothing but a space or a comma between them."""


def joined(sdcs: Sequence[SDC]) -> tuple[SDC, ...]:
    """The top-level clauses of a command, with those that are one together."""
    found: list[SDC] = []
    for sdc in sdcs:
        last = found[-1] if found else None
        one = (_negated(last, sdc) or _together(last, sdc)) if last is not None else None
        shared = _shared(last, sdc) if last is not None else None
        found[len(found) - (one is not None) :] = [one or shared or sdc]
    return tuple(found)


def verb_words(sdc: SDC) -> list[str]:
    """The words of a clause's relation, bare."""
    return [bare(word.text) for word in sdc.relation]


def whole_words(words: Sequence[Span]) -> tuple[Span, ...]:
    """Words whose parts were taken for words, as they are written: "U-turn"."""
    found: list[Span] = []
    for word in words:
        if found and found[-1].end == word.start:
            word = Span(found[-1].start, found.pop().text + word.text)  # noqa: PLW2901
        found.append(word)
    return tuple(found)


def arguments_of(sdc: SDC) -> tuple[SDC, ...]:
    """What a clause's words name as its arguments."""
    return tuple(part for part in (*sdc.landmark1, *sdc.landmark2) if not part.is_implicit)


def subject_of(sdc: SDC) -> SDC | None:
    """What a clause's words name as its subject."""
    return next((part for part in sdc.figure if not part.is_implicit), None)


def only_object(sdc: SDC) -> SDC | None:
    """The OBJECT of a clause that has no other argument."""
    own = arguments_of(sdc)
    return own[0] if len(own) == 1 and own[0].type == "OBJECT" else None


def _together(before: SDC, sdc: SDC) -> SDC | None:
    """One clause of two that lie side by side and are none without each other.

    "The drum" and "to the gate"; "make sure the drum" and "ends up on the truck"; "gensets" and
    "go to the gate".
    """
    if not side_by_side(before, sdc, _JOINED):
        return None
    if sdc.type in ("PATH", "PLACE"):
        return _led(before, sdc) if sdc.landmark1 else None
    if before.type != "EVENT" or sdc.type != "EVENT" or subject_of(sdc) or not _leads(sdc):
        return None
    said = verb_words(before)
    theme, verb = only_object(before), verb_of(tuple(said))
    if not arguments_of(before) and verb.is_open and side_by_side(before, sdc, len(" ")):
        theme = SDC("OBJECT", words=before.relation)
    elif verb.classes or not (verb.leads_on or "that" in said or INTERJECTIONS.issuperset(said)):
        return None
    if theme is None or names_robot(theme) or names_forks(theme):
        return None
    return replace(sdc, figure=(theme,))


def _led(before: SDC, where: SDC) -> SDC | None:
    """A thing with where it comes from and goes: "the drum", "from the truck", "to the gate"."""
    if before.type == "OBJECT":
        return SDC("EVENT", figure=IMPLICIT_FIGURE, landmark1=(before,), landmark2=(where,))
    if before.type == "EVENT" and not before.relation:
        return replace(before, landmark2=(*before.landmark2, where))
    return None


def _negated(before: SDC, sdc: SDC) -> SDC | None:
    """A clause with the negation that a tree has before it: "do not" and "lift it"."""
    said = verb_words(before)
    if before.type != "EVENT" or sdc.type != "EVENT" or arguments_of(before) or subject_of(before):
        return None
    if not (negated(before) and side_by_side(before, sdc, _JOINED)):
        return None
    if not all(is_negation(w) or w in _POLITE or normalise(w) in LEADING for w in said):
        return None
    return replace(sdc, relation=(*before.relation, *sdc.relation))


def _shared(before: SDC, sdc: SDC) -> SDC | None:
    """A clause with the subject of the one before: "the drum comes off it and goes to the gate"."""
    subject = subject_of(before)
    if before.type != "EVENT" or subject is None or names_robot(subject):
        return None
    if sdc.type != "EVENT" or subject_of(sdc) or not _leads(sdc):
        return None
    goes = verb_of(tuple(verb_words(sdc))).classes == {"going"}
    near = side_by_side(before, sdc, len(" and "))
    return replace(sdc, figure=(subject,)) if goes and near else None


def _leads(sdc: SDC) -> bool:
    """Whether a clause says where to, and names nothing that goes there."""
    types = {part.type for part in arguments_of(sdc)}
    return bool(types & {"PLACE", "PATH"}) and "OBJECT" not in types
