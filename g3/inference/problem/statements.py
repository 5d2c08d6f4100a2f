"""Sentences that ask for nothing: "there are two crates by the gate", "forklift 4", "thank you".

People say what they see, whom they speak to, and why. What such a sentence names is spoken of
then, but nothing is to be done about it. A command that has nothing else keeps them all.
"""

from __future__ import annotations

from collections.abc import Sequence

from g3.inference.problem.phrases import is_pronoun, names_robot
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.groups import noun_leaf
from g3.language.discourse.negation import negated
from g3.language.lexicon.field_words import bare_words, normalise
from g3.language.lexicon.measures import seconds_said
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.language.similarity.presence import may_be_absent
from g3.sdc.clauses import SDC


def without_statements(sdcs: Sequence[SDC], nouns: Nouns) -> tuple[SDC, ...]:
    """The clauses that ask for something, and of the others what they name.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    nouns
        What words may name in the world.
    """
    states = [_states(sdc, nouns) for sdc in sdcs]
    if all(stated or sdc.type != "EVENT" for sdc, stated in zip(sdcs, states, strict=True)):
        return tuple(sdcs)
    return tuple(
        part
        for sdc, stated in zip(sdcs, states, strict=True)
        for part in (_named(sdc, nouns) if stated else (sdc,))
    )


def _states(sdc: SDC, nouns: Nouns) -> bool:
    """Check that a clause only states or calls something; what it forbids counts."""
    words = bare_words(sdc.relation)
    parts = (*sdc.landmark1, *sdc.landmark2)
    if negated(sdc) or sdc.type != "EVENT":
        return False
    if not words:
        return bool(parts) and all(names_nothing(part, nouns) for part in parts)
    named = [p for p in parts if not (p.is_implicit or names_robot(p))]
    subjects = [p for p in sdc.figure if not (p.is_implicit or names_robot(p))]
    verb = verb_of(tuple(words))
    head = words[verb.start] if verb.start < len(words) else ""
    asks = normalise(head) in WORDS["asking"]
    tells = verb.is_open or (asks and not verb.classes)
    wanted = asks and head.endswith("s") and not subjects  # "(he) wants it soon"
    loads = any(nouns.name_load(noun_leaf(p).words) for p in named)
    if (tells and subjects and all(map(is_pronoun, subjects))) or (wanted and not loads):
        return not loads
    if any(part.type == "EVENT" and not _asks(part) for part in parts):
        return False
    waits = any(seconds_said(bare_words(part.words)) is not None for part in named) and not loads
    idle = bool(named) and all(names_nothing(part, nouns) for part in named)
    if verb.is_open and (waits or idle):
        return True  # "give him a minute"
    calls = verb.is_open and nouns.call_robot(sdc.relation)
    return (
        (calls and all(part.type == "OBJECT" for part in parts))
        or normalise(head) in WORDS["regarding"]
        or words[0] == "while"
        or (bool(subjects) and head in WORDS["stating"])
        or not (named or subjects or verb.classes)
    )


def names_nothing(sdc: SDC, nouns: Nouns) -> bool:
    """Check that a clause is an OBJECT that names nothing that there is: "a bit quick"."""
    if sdc.type != "OBJECT":
        return False
    words = noun_leaf(sdc).words[-1:]
    said = bare_words(words)
    if not said or sdc.figure or not may_be_absent(said[0]):
        return bool(said) and said[0] in WORDS["manners"]
    return not (nouns.name_load(words) or nouns.name_other(words))


def _asks(sdc: SDC) -> bool:
    """Check that an EVENT is a question within a clause: "see what he wants"."""
    return bool(WORDS["questioning"].intersection(bare_words(sdc.relation)[:1]))


def _named(sdc: SDC, nouns: Nouns) -> tuple[SDC, ...]:
    """The OBJECTs that a statement names, or the load that was taken for its verb."""
    parts = (*sdc.figure, *sdc.landmark1, *sdc.landmark2)
    if all(p.is_implicit for p in parts) and nouns.name_load(sdc.relation):
        return (SDC("OBJECT", words=sdc.relation),)
    if nouns.call_robot(sdc.relation):
        return ()
    named = (p for p in parts if p.type == "OBJECT" and not (p.is_implicit or names_robot(p)))
    return tuple(part for part in named if not names_nothing(part, nouns))
