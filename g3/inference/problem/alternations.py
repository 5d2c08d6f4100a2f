"""Other ways to say the same, as clauses that say it plainly.

What is moved is the first OBJECT of a plain clause, and where to comes after it. People also say
"load the truck with the drum", "give the drum a lift", "make a left turn", "drum to the gate" and
"make sure that the drum ends up on the truck". Levin, English Verb Classes and Alternations (1993),
has the classes of verbs (sections 9.7, 10.3, 13.5), and VerbNet those of today. Words are moved,
never made up, and a clause that is plain already stays as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from g3.inference.problem.clause_roles import is_goal
from g3.inference.problem.joined_clauses import (
    arguments_of,
    joined,
    only_object,
    subject_of,
    verb_words,
    whole_words,
)
from g3.inference.problem.measures_apart import measures_apart
from g3.inference.problem.phrases import (
    is_floor,
    is_measure,
    is_pronoun,
    names_forks,
    names_robot,
)
from g3.inference.problem.plain_phrases import plain_phrases
from g3.inference.problem.repetitions import repeated
from g3.inference.problem.restored_words import restored
from g3.inference.problem.statements import without_statements
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, field_words, normalise
from g3.language.lexicon.verb_chains import is_nominal, verb_of
from g3.language.lexicon.word_sets import (
    AN,
    ARTICLES,
    ASKING,
    BESIDE,
    FILLING,
    GENERIC,
    GETTING,
    HANDLING_VERBS,
    HELD,
    LIGHT,
    LOWERING,
    REGARDING,
    RELATIVE,
    YOU,
)
from g3.sdc.clauses import SDC, SDCType, Span, all_words
from g3.sdc.sdc_notation import IMPLICIT_FIGURE


def plain(sdcs: Sequence[SDC], nouns: Nouns, text: str = "") -> tuple[SDC, ...]:
    """The clauses of a command as plain ones.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    nouns
        What words may name in the world.
    text
        The command; empty where only its clauses are known.
    """
    whole = restored(list(map(_whole, sdcs)), text, nouns)
    wanted = [_wanted(plain_phrases(sdc), nouns) for sdc in joined(whole)]
    asking = without_statements(wanted, nouns)
    return repeated([_plain(sdc, nouns) for sdc in asking], nouns)


def _whole(sdc: SDC) -> SDC:
    """A clause whose words are whole: "right-hand" and "twenty-five" are one word each."""
    parts = (tuple(map(_whole, own)) for own in (sdc.figure, sdc.landmark1, sdc.landmark2))
    return SDC(sdc.type, whole_words(sdc.words), whole_words(sdc.relation), *parts)


def _wanted(sdc: SDC, nouns: Nouns) -> SDC:
    """A thing that is named where it isn't is wanted there: "the drum on the truck, please"."""
    if sdc.type != "OBJECT":
        return sdc
    return _result(SDC("EVENT", figure=IMPLICIT_FIGURE, landmark1=(sdc,)), nouns) or sdc


def _plain(sdc: SDC, nouns: Nouns) -> SDC:
    if sdc.type != "EVENT":
        return sdc
    sdc = measures_apart(sdc)
    for alternate in _ALTERNATIONS:
        sdc = alternate(sdc, nouns) or sdc
    first, second = (
        tuple(_plain(part, nouns) for part in own) for own in (sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, landmark1=first, landmark2=second)


def _names_load(sdc: SDC, nouns: Nouns) -> bool:
    """Whether a noun is a label of a load, and not only like one."""
    return not nouns.loads.isdisjoint(field_words(noun_leaf(sdc).words))


def _held(sdc: SDC, nouns: Nouns) -> SDC | None:
    """What the robot holds is named by that: "put down the crate you are holding"."""
    if nouns.state.held is None:
        return None
    parts = arguments_of(sdc)
    if not any(map(_is_held, (*parts, *(inner for part in parts for inner in part.landmark1)))):
        return None
    first, second = (
        tuple(new for part in own for new in _without_held(part))
        for own in (sdc.landmark1, sdc.landmark2)
    )
    return replace(sdc, landmark1=first, landmark2=second)


def _is_held(sdc: SDC) -> bool:
    """Whether a clause says that the robot has something: "you are holding"."""
    said = HELD.intersection(verb_words(sdc))
    return sdc.type == "EVENT" and bool(said) and all(map(names_robot, sdc.figure))


def _without_held(sdc: SDC) -> tuple[SDC, ...]:
    """What is left of an argument: a thing alone, and where it goes."""
    if _is_held(sdc):
        return tuple(p for p in arguments_of(sdc) if not any(map(names_forks, p.landmark1)))
    held = [part for part in sdc.landmark1 if _is_held(part)]
    return (*sdc.figure, *(p for part in held for p in _without_held(part))) if held else (sdc,)


def _fronted(sdc: SDC, nouns: Nouns) -> SDC | None:
    """A load that is named before the verb, and meant by "it" after it: "the drum, lift it"."""
    if not verb_of(tuple(verb_words(sdc))).classes & HANDLING_VERBS:
        return None
    subject = subject_of(sdc)
    theme, *others = (*((subject,) if subject else ()), *arguments_of(sdc)) or (None,)
    if theme is None:
        return None
    named = theme.type == "OBJECT" and not (names_robot(theme) or is_pronoun(theme))
    again = next((p for p in others if p.type == "OBJECT"), None)
    if not named or again is None or not is_pronoun(again) or not sdc.relation:
        return None
    first = all_words(theme)[0].start < sdc.relation[0].start < all_words(again)[0].start
    if not (first and nouns.name_load(noun_leaf(theme).words)):
        return None
    rest = tuple(part for part in others if part is not again)
    return replace(sdc, figure=IMPLICIT_FIGURE, landmark1=(theme,), landmark2=rest)


def _put_beside(sdc: SDC, nouns: Nouns) -> SDC | None:
    """Where the load on the forks is put, taken for where it is: "lower the drum by the gate"."""
    held = nouns.state.held
    theme = next(iter(sdc.landmark1), None)
    if held is None or theme is None or len(theme.figure) != 1 or not theme.landmark1:
        return None
    said = concepts(field_words(theme.relation))
    if verb_of(tuple(verb_words(sdc))).classes != {"placing"} or not said & BESIDE:
        return None
    names = GENERIC.union(map(normalise, nouns.state.thing(held).labels))
    named = noun_leaf(theme).words
    own = YOU.intersection(bare(word.text) for word in named[:1])
    if not (own or names.intersection(field_words(named))):
        return None
    place = SDC("PLACE", relation=theme.relation, landmark1=theme.landmark1)
    floors = [p for p in sdc.landmark2 if p.landmark1 and is_floor(p.landmark1[0])]
    others = (*sdc.landmark1[1:], *(p for p in sdc.landmark2 if p not in floors))
    if any(part.type in ("PLACE", "PATH") for part in others):
        return None
    return replace(sdc, landmark1=theme.figure, landmark2=(place, *others))


def _loaded(sdc: SDC, nouns: Nouns) -> SDC | None:
    """Somewhere with the load that is on the forks: "stop there with the drum still up"."""
    parts = arguments_of(sdc)
    if nouns.state.held is None or any(part.type == "OBJECT" for part in parts):
        return None
    if verb_of(tuple(verb_words(sdc))).classes & {"placing", "turning"} or not sdc.relation:
        return None
    kept = [part for part in parts if not _says_what_is_held(part)]
    if len(kept) == len(parts):
        return None
    return replace(sdc, landmark1=tuple(kept[:1]), landmark2=tuple(kept[1:]))


def _says_what_is_held(part: SDC) -> bool:
    """Whether a phrase says that something is on the forks: "with the drum", "on the forks"."""
    if part.type not in ("PATH", "PLACE") or not part.landmark1:
        return False
    return verb_words(part)[:1] == ["with"] or names_forks(part.landmark1[0])


def _goes(sdc: SDC, nouns: Nouns) -> SDC | None:
    """A load that goes somewhere, named before the verb: "the drums go to the gate"."""
    theme, *goals = arguments_of(sdc) or (None,)
    if theme is None or theme.type != "OBJECT" or not goals or subject_of(sdc) or not sdc.relation:
        return None
    first = all_words(theme)[0].start <= sdc.relation[-1].start
    others = any(part.type not in ("PATH", "PLACE") for part in goals)
    if not first or others or verb_of(tuple(verb_words(sdc))).classes != {"going"}:
        return None
    if not nouns.name_load(noun_leaf(theme).words):
        return None
    return replace(sdc, figure=(theme,), landmark1=tuple(goals), landmark2=())


def _filled(sdc: SDC, nouns: Nouns) -> SDC | None:
    """What is filled comes first, and what with in it: "load the truck with the drum"."""
    parts = arguments_of(sdc)
    if not FILLING.isdisjoint(verb_words(sdc)) and [p.type for p in parts[:1]] == ["OBJECT"]:
        company = [p for p in parts[1:] if verb_words(p) == ["with"] and p.landmark1]
        if len(parts) == 2 and company and not _names_load(parts[0], nouns):
            own = (*sdc.relation, *company[0].relation)
            return replace(sdc, relation=own, landmark1=company[0].landmark1, landmark2=parts[:1])
    filled = only_object(sdc)
    if filled is None or not filled.figure or not filled.landmark1:
        return None
    if FILLING.isdisjoint(verb_words(sdc)) or [bare(w.text) for w in filled.relation] != ["with"]:
        return None
    if _names_load(filled.figure[0], nouns):
        return None
    return replace(
        sdc,
        relation=(*sdc.relation, *filled.relation),
        landmark1=filled.figure,
        landmark2=filled.landmark1,
    )


def _needed(sdc: SDC, nouns: Nouns) -> SDC | None:
    """What needs something is where that goes: "the truck needs the drum"."""
    theme = only_object(sdc)
    needs = subject_of(sdc)
    if theme is None or needs is None or ASKING.isdisjoint(map(normalise, verb_words(sdc))):
        return None
    if names_robot(needs) or _names_load(needs, nouns):
        return None
    if not _names_load(theme, nouns):
        return None
    return replace(sdc, figure=IMPLICIT_FIGURE, landmark1=(theme,), landmark2=(needs,))


def _result(sdc: SDC, nouns: Nouns) -> SDC | None:
    """Where something shall be, if it isn't there: "I want the drum on the truck"."""
    theme = only_object(sdc)
    if theme is None or len(theme.figure) != 1 or len(theme.landmark1) != 1:
        return None
    if not RELATIVE.isdisjoint(verb_words(theme)):
        return None
    said = concepts(field_words(theme.relation))
    own = verb_words(sdc)
    classes = verb_of(tuple(own)).classes
    gets = not GETTING.isdisjoint(own) and nouns.name_other(noun_leaf(theme.landmark1[0]).words)
    wants = not own or not ASKING.isdisjoint(map(normalise, own)) or gets
    puts = classes == {"placing"} and LOWERING.isdisjoint((*own, *map(normalise, own)))
    where = puts and "down" not in own if said & BESIDE else "on" in said
    if not where or "from" in said or not (wants or classes in ({"placing"}, {"carrying"})):
        return None
    one, other = (
        field_words(noun_leaf(part).words) for part in (theme.figure[0], theme.landmark1[0])
    )
    if nouns.stands_on(one, other) or not nouns.loads.intersection(one):
        return None
    place = SDC("PLACE", relation=theme.relation, landmark1=theme.landmark1)
    return replace(sdc, landmark1=theme.figure, landmark2=(place,))


def _light(sdc: SDC, _: Nouns) -> SDC | None:
    """A noun that says what to do: "make a left turn", "give the drum a lift"."""
    sdc = _with_its_noun(sdc)
    words = tuple(verb_words(sdc))
    first = next(iter(sdc.landmark1), None)
    start = verb_of(words).start
    if first is None or first.type != "OBJECT" or LIGHT.isdisjoint(words[start : start + 1]):
        return None
    others = (*sdc.landmark1[1:], *sdc.landmark2)
    if not all(map(is_measure, sdc.landmark1[1:])) or len(first.figure) > 1:
        return None
    leaf = first.figure[0] if first.figure else first
    theme, act = _apart(whole_words(leaf.words))
    own = [bare(word.text) for word in act]
    if not leaf.is_leaf or len(own) < 2 or own[0] not in AN | {"one", "another"}:
        return None
    acts = is_nominal(own[-1]) or normalise(own[-1]) in REGARDING
    if not acts and own[1:] not in (["left"], ["right"]):
        return None
    around = tuple(word for word in act[:-1] if bare(word.text) not in ARTICLES)
    themes = [SDC("OBJECT", words=theme)] if theme else []
    rest = []
    if first.relation and field_words(first.relation) == ("of",):
        themes += first.landmark1
    elif first.relation:
        kind: SDCType = "PATH" if is_goal(first) or not first.landmark1 else "PLACE"
        rest = [SDC(kind, relation=first.relation, landmark1=first.landmark1)]
    relation = (*sdc.relation[:start], act[-1], *around, *sdc.relation[start + 1 :])
    parts = (*themes, *rest, *others)
    return replace(sdc, relation=relation, landmark1=parts[:1], landmark2=parts[1:])


def _with_its_noun(sdc: SDC) -> SDC:
    """A side after an article is a noun, however a tree has it: "take a left"."""
    measures = tuple(part for part in arguments_of(sdc) if is_measure(part))
    others = (part for part in arguments_of(sdc) if part not in measures)
    said = tuple(word for part in others for word in all_words(part))
    if [bare(word.text) for word in said] not in (["a", "left"], ["a", "right"]):
        return sdc
    return replace(sdc, landmark1=(SDC("OBJECT", words=said),), landmark2=measures)


def _apart(words: tuple[Span, ...]) -> tuple[tuple[Span, ...], tuple[Span, ...]]:
    """The two nouns of "the drum a lift", each with its article; the first is empty for one."""
    inside = [i for i, word in enumerate(words) if i and bare(word.text) in AN]
    cut = inside[-1] if inside else 0
    return words[:cut], words[cut:]


_ALTERNATIONS: tuple[Callable[[SDC, Nouns], SDC | None], ...] = (
    _held,
    _fronted,
    _put_beside,
    _loaded,
    _goes,
    _light,
    _filled,
    _needed,
    _result,
)
