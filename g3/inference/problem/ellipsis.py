"""Words that a tree or a text leaves out: "far tires, *truck*", "…, then *put* the crate *there*".

Telegrams name a load and where it goes, with nothing between. Trees, learned from sentences, then
often lack the second noun, or have it as a way. Of another load the same is often not said again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest

from g3.inference.problem.phrases import (
    arguments_of,
    is_nounless,
    is_there,
    names_held,
    names_robot,
    subject_of,
    tells_standing,
    verb_words,
)
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.verb_classes import HANDLING_VERBS
from g3.language.parsing.words import cut
from g3.sdc.clauses import SDC, Span, all_words
from g3.sdc.sdc_notation import IMPLICIT_FIGURE


def restored(sdcs: Sequence[SDC], text: str, nouns: Nouns) -> tuple[SDC, ...]:
    """Return the top-level clauses with goals that the tree leaves out.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    text
        The command; empty where only its clauses are known.
    nouns
        What words may name in the world.
    """
    tokens = cut(text).spans
    sdcs = _with_mentions(sdcs, tokens, nouns)
    covered = {word.start for sdc in sdcs for word in all_words(sdc)}
    return tuple(_with_goal(sdc, tokens, covered, nouns) for sdc in sdcs)


def _with_mentions(sdcs: Sequence[SDC], tokens: Sequence[Span], nouns: Nouns) -> Sequence[SDC]:
    """Clauses after what words in no clause speak of: "*the tires* are mine, put *them* …".

    What is taken back is still spoken of where a later clause names it by no noun. A load is added
    only if no clause names one before.
    """
    leaves = [leaf for sdc in sdcs for leaf in (*_leaves(sdc), *_goals_alone(sdc))]
    starts = {all_words(leaf)[0].start: leaf for leaf in leaves if _stands_for(leaf)}
    first = min(starts, default=-1)
    covered = {word.start for sdc in sdcs for word in all_words(sdc)}
    free = [token for token in tokens if token.start < first and token.start not in covered]
    before = [leaf for leaf in leaves if all_words(leaf)[0].start < first]
    has_load = any(nouns.name_load(leaf.words) for leaf in before if leaf.type == "OBJECT")
    mentions = [
        noun
        for noun in _noun_phrases(free, nouns)
        if not (has_load if nouns.name_load(noun[-1:]) else is_nounless(starts[first]))
    ]
    bare_goal, loads = starts.get(first), [n for n in mentions if nouns.name_load(n[-1:])]
    if bare_goal is not None and bare_goal.type == "EVENT":
        theme = tuple(SDC("OBJECT", words=noun) for noun in loads[-1:])
        told = replace(bare_goal, landmark1=(*theme, *bare_goal.landmark1))
        return tuple(told if sdc is bare_goal else sdc for sdc in sdcs)
    spoken = (SDC("OBJECT", words=noun) for noun in mentions)
    return (*(own if nouns.name_load(own.words[-1:]) else _place(own) for own in spoken), *sdcs)


def _place(mark: SDC) -> SDC:
    """A place about something, for what is no load."""
    return SDC("PLACE", landmark1=(mark,))


def _goals_alone(sdc: SDC) -> tuple[SDC, ...]:
    """A telegram that says no more than where something goes: "in the truck, quick"."""
    parts = arguments_of(sdc) if _is_telegram(sdc) else ()
    return (sdc,) if parts and all(part.type in ("PLACE", "PATH") for part in parts) else ()


def _stands_for(leaf: SDC) -> bool:
    """Check that a leaf means something without naming it: "them", "there", "both"."""
    if leaf.type == "OBJECT":
        again = WORDS["it"] | WORDS["universal"]  # "them both"
        return is_nounless(leaf) or again.issuperset(bare_words(leaf.words))
    return leaf.type == "EVENT" or is_there(leaf)


def _noun_phrases(tokens: Sequence[Span], nouns: Nouns) -> list[tuple[Span, ...]]:
    """Runs of words that end in names of things: "the far tire pallet"."""
    found: list[tuple[Span, ...]] = []
    run: list[Span] = []
    for token, following in zip_longest(tokens, tokens[1:]):
        names = nouns.name_thing(token)
        run = [*run, token] if names or _tells(token) else []
        ends = (
            following is None or following.start > token.end + 1 or not nouns.name_thing(following)
        )
        if names and ends:
            found.append(tuple(run))
            run = []
    return found


def _tells(token: Span) -> bool:
    """Check that a word before a noun belongs to it: "the far", "all"."""
    word = bare(token.text)
    if word in WORDS["determiners"] | WORDS["quantifiers"] or word in COUNTS["cardinals"]:
        return True
    return bool(concepts(field_words([token]))) and word not in WORDS["place_prepositions"]


def _leaves(sdc: SDC) -> list[SDC]:
    own = [sdc] if sdc.type in ("OBJECT", "PLACE") and not sdc.children() and all_words(sdc) else []
    return own + [leaf for part in sdc.children() for leaf in _leaves(part)]


def _is_telegram(sdc: SDC) -> bool:
    """Check that a clause has no verb and no subject."""
    return sdc.type == "EVENT" and not sdc.relation and all(p.is_implicit for p in sdc.figure)


def _with_goal(sdc: SDC, tokens: Sequence[Span], covered: set[int], nouns: Nouns) -> SDC:
    """A telegram with the noun behind its load as its goal: "far tires, truck"."""
    parts = arguments_of(sdc)
    if not _is_telegram(sdc) or not parts or any(part.type != "OBJECT" for part in parts):
        return sdc
    theme, *others = parts
    if not _may_be_load(theme, nouns) or len(others) > 1:
        return sdc
    mark = others[0] if others else _noun_behind(theme, tokens, covered, nouns)
    if mark is None or not nouns.name_other(all_words(mark)[-1:]):
        return sdc
    inside = (token for token in tokens if _end(theme) <= token.start < all_words(mark)[0].start)
    if any(bare(token.text) in ("and", "&") for token in inside):
        return sdc
    return replace(sdc, landmark1=(theme,), landmark2=(SDC("PLACE", landmark1=(mark,)),))


def _noun_behind(theme: SDC, tokens: Sequence[Span], covered: set[int], nouns: Nouns) -> SDC | None:
    """The noun behind a load that is in no clause; None if there are several, or none."""
    behind = [token for token in tokens if token.start >= _end(theme)]
    stop = (
        i for i, t in enumerate(behind) if t.start in covered or t.text in WORDS["sentence_ends"]
    )
    own = [token for token in behind[: next(stop, None)] if bare(token.text).isalnum()]
    named = [i for i, t in enumerate(own) if nouns.name_load((t,)) or nouns.name_other((t,))]
    return SDC("OBJECT", words=tuple(own[: named[0] + 1])) if len(named) == 1 else None


def _end(theme: SDC) -> int:
    return all_words(theme)[-1].end


_CLAUSES_BACK = 2
"""Number of clauses back to which a repetition refers, at most."""


def repeated(sdcs: Sequence[SDC], nouns: Nouns) -> tuple[SDC, ...]:
    """The top-level clauses, plain ones, where what names only a load says the same of it.

    The same is what the clause before says: its verb, and where to.
    """
    found: list[SDC] = []
    for sdc in sdcs:
        if found and _names_the_same(sdc):
            found.append(_with_things_of(found[-1], sdc))
            continue
        load = _load(sdc, nouns)
        said = [_same(before, load) for before in found[-_CLAUSES_BACK:]] if load else []
        found.append(next(filter(None, reversed(said)), sdc))
    return tuple(found)


def _names_the_same(sdc: SDC) -> bool:
    """Check that a clause leads things like those before elsewhere: "the same on the truck"."""
    things = [p for p in (subject_of(sdc), *arguments_of(sdc)) if p and p.type == "OBJECT"]
    leads = any(part.type in ("PLACE", "PATH") for part in arguments_of(sdc))
    same = [word for thing in things for word in _said(thing) if word not in WORDS["articles"]]
    return sdc.type == "EVENT" and leads and same == ["same"]


def _with_things_of(before: SDC, sdc: SDC) -> SDC:
    """A clause about things like those of the clause before."""
    goals = tuple(part for part in arguments_of(sdc) if part.type != "OBJECT")
    subject = subject_of(before)
    if subject is not None and not names_robot(subject):
        return replace(before, landmark1=goals, landmark2=())
    things = tuple(part for part in before.landmark1 if part.type == "OBJECT")
    return replace(before, landmark1=things, landmark2=goals)


def _load(sdc: SDC, nouns: Nouns) -> SDC | None:
    """The load that a clause names, if it says nothing else but that the same is wanted."""
    if WORDS["again"].isdisjoint(_said(sdc)) and verb_words(sdc) not in (["do"], ["does"]):
        alone = arguments_of(sdc) if _is_telegram(sdc) else ()
        named = [p for p in alone if p.type == "OBJECT" and _may_be_load(p, nouns)]
        return named[0] if len(named) == len(alone) == 1 else None
    parts: list[SDC] = []
    if sdc.type == "EVENT" and WORDS["same_again"].issuperset(verb_words(sdc)):
        subject = subject_of(sdc)
        own = (*((subject,) if subject else ()), *arguments_of(sdc))
        parts = [inner for part in own for inner in _inside(part)]
    elif sdc.type in ("PLACE", "PATH"):
        parts = [part for part in _inside(sdc) if part is not sdc]
    elif sdc.type == "OBJECT":
        again = sdc.figure and not sdc.landmark1 and WORDS["same_again"].issuperset(verb_words(sdc))
        parts = list(sdc.figure) if again else [sdc]
    loads = [p for p in parts if p.type == "OBJECT" and _may_be_load(p, nouns)]
    others = [p for p in parts if p not in loads]
    if len(loads) != 1 or any(is_there(p) or WORDS["again"].isdisjoint(_said(p)) for p in others):
        return None
    return _without_again(loads[0])


def _said(sdc: SDC) -> list[str]:
    return bare_words(all_words(sdc))


def _inside(part: SDC) -> tuple[SDC, ...]:
    """Return the clauses that an argument names: "the drum" of "the same with the drum"."""
    said = {word for figure in part.figure for word in _said(figure)}
    same = WORDS["same_again"].issuperset(said - WORDS["articles"])
    if part.landmark1 and same and WORDS["same_again"].issuperset(verb_words(part)):
        return part.landmark1
    return (part,)


def _may_be_load(sdc: SDC, nouns: Nouns) -> bool:
    """Check that an OBJECT names a load, or leaves its noun out: "the other one", "the left"."""
    noun = noun_leaf(sdc).words
    if not noun or nouns.name_load(noun) or names_held(sdc):
        return bool(noun)
    return bare(noun[-1].text) in WORDS["nounless"] or bool(concepts(field_words(noun[-1:])))


def _without_again(load: SDC) -> SDC:
    """A load without words before it that a tree has taken for its own: "this also the drum"."""
    start = 0
    while start < len(load.words) - 1 and bare(load.words[start].text) in WORDS["same_again"]:
        start += 1
    return replace(load, words=load.words[start:]) if load.words else load


def _same(before: SDC, load: SDC) -> SDC | None:
    """Return a clause for another load; None if it puts nothing anywhere.

    "The other one" stands where the first one did: "a crate from the gate, then the other one".
    """
    if before.type != "EVENT":
        return None
    goals = tuple(p for p in arguments_of(before) if p.type in ("PLACE", "PATH"))
    handles = verb_of(tuple(verb_words(before))).classes & HANDLING_VERBS or not before.relation
    subject = subject_of(before)
    moves = subject is not None and not names_robot(subject)
    if not goals or not (handles or moves):
        return None
    theme = next((p for p in (subject, *before.landmark1) if p and p.type == "OBJECT"), None)
    if theme and tells_standing(theme) and load.is_leaf and is_nounless(load):
        load = replace(theme, figure=(load,))
    if moves:
        return replace(before, figure=(load,), landmark1=goals, landmark2=())
    return replace(before, figure=IMPLICIT_FIGURE, landmark1=(load,), landmark2=goals)
