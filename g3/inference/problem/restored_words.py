"""Words of a text that its tree leaves out: "the tires *all* on the truck", "far tires, *truck*".

Telegrams name a load and where it goes, with nothing between. Trees, learned from sentences, then
often lack the second noun, or have it as a way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from g3.inference.problem.phrases import arguments_of, side_by_side, verb_words
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.groups import group
from g3.language.lexicon.field_words import bare, bare_words
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.language.parsing.words import cut
from g3.sdc.clauses import SDC, Span, all_words


def restored(sdcs: Sequence[SDC], text: str, nouns: Nouns) -> tuple[SDC, ...]:
    """Return the top-level clauses with quantifiers and goals that the tree leaves out.

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
    covered = {word.start for sdc in sdcs for word in all_words(sdc)}
    for before, token, after in zip((None, *tokens), tokens, (*tokens[1:], None), strict=False):
        if token.start not in covered and _counts_all(before, token, after):
            sdcs = _with_quantifier(sdcs, token, nouns)
    named = [sdc for sdc in sdcs if text and _only_names(sdc, nouns)]
    covered -= {word.start for sdc in named for word in sdc.relation}
    others = [sdc for sdc in sdcs if sdc not in named] or sdcs
    return tuple(_with_goal(sdc, tokens, covered, nouns) for sdc in _joined(others))


def _only_names(sdc: SDC, nouns: Nouns) -> bool:
    """Check that what a tree has as a verb is the name of no load: "left tires *flatbed*"."""
    alone = sdc.type == "EVENT" and sdc.relation and not arguments_of(sdc)
    verb = verb_of(tuple(verb_words(sdc)))
    return bool(alone) and not verb.classes and nouns.name_other(sdc.relation[-1:])


def _counts_all(before: Span | None, token: Span, after: Span | None) -> bool:
    beside = (set(bare_words(filter(None, own))) for own in ((before,), (after,)))
    counts = bare(token.text) in WORDS["counting_all"]
    return counts and all(map(set.isdisjoint, beside, (WORDS["before_all"], WORDS["after_all"])))


def _with_quantifier(sdcs: Sequence[SDC], token: Span, nouns: Nouns) -> tuple[SDC, ...]:
    """Clauses whose last load before a quantifier has it: "the tires all on the truck"."""
    leaves = [leaf for sdc in sdcs for leaf in _leaves(sdc)]
    before = [leaf for leaf in leaves if leaf.words[-1].end <= token.start]
    before = [leaf for leaf in before if nouns.name_load(leaf.words)]
    last = max(before, key=lambda leaf: leaf.words[-1].start, default=None)
    if last is None or group(last).number == "singular":
        return tuple(sdcs)
    counted = replace(last, words=(token, *last.words))
    return tuple(_replaced(sdc, last, counted) for sdc in sdcs)


def _leaves(sdc: SDC) -> list[SDC]:
    own = [sdc] if sdc.type == "OBJECT" and sdc.words else []
    return own + [leaf for part in sdc.children() for leaf in _leaves(part)]


def _replaced(sdc: SDC, old: SDC, new: SDC) -> SDC:
    if sdc is old:
        return new
    figure, first, second = (
        tuple(_replaced(part, old, new) for part in own)
        for own in (sdc.figure, sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, figure=figure, landmark1=first, landmark2=second)


def _joined(sdcs: Sequence[SDC]) -> list[SDC]:
    """Clauses where a load and the way after it are one: "carried load: left truck"."""
    found: list[SDC] = []
    for sdc in map(_unwrapped, sdcs):
        before = found[-1] if found else None
        goals = arguments_of(sdc)
        leads = _is_telegram(sdc) and all(part.type in ("PATH", "PLACE") for part in goals)
        if before is not None and before.type == "OBJECT" and leads and goals:
            found[-1] = replace(sdc, landmark1=(before,), landmark2=goals)
        else:
            found.append(sdc)
    return found


def _is_telegram(sdc: SDC) -> bool:
    """Check that a clause has no verb and no subject."""
    return sdc.type == "EVENT" and not sdc.relation and all(p.is_implicit for p in sdc.figure)


def _unwrapped(sdc: SDC) -> SDC:
    """A telegram without ways that lead nowhere: "near boxes: container", "crate left trailer"."""
    if not _is_telegram(sdc):
        return sdc
    first, *others = arguments_of(sdc) or (None,)
    if first is None:
        return sdc
    if first.type == "PATH" and not first.relation and first.landmark1 and first.landmark2:
        first, others = first.landmark1[0], [*first.landmark2, *others]
    goals = (_with_side(part) for part in others)
    return replace(sdc, landmark1=(first,), landmark2=tuple(goals))


def _with_side(part: SDC) -> SDC:
    """A place whose side is that of its landmark: "left trailer"."""
    mark = part.landmark1[0] if len(part.landmark1) == 1 else None
    if part.type not in ("PATH", "PLACE") or mark is None or not mark.words:
        return part
    aside = part.relation and all(bare(word.text) in WORDS["aside"] for word in part.relation)
    if not aside or not side_by_side(SDC("OBJECT", words=part.relation), mark, len(" ")):
        return part
    return SDC("PLACE", landmark1=(replace(mark, words=(*part.relation, *mark.words)),))


def _with_goal(sdc: SDC, tokens: Sequence[Span], covered: set[int], nouns: Nouns) -> SDC:
    """A telegram with the noun behind its load as its goal: "far tires, truck"."""
    parts = arguments_of(sdc)
    if not _is_telegram(sdc) or not parts or any(part.type != "OBJECT" for part in parts):
        return sdc
    theme, *others = parts
    if not nouns.name_load(all_words(theme)[-1:]) or len(others) > 1:
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
