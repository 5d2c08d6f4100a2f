"""Nouns that name nothing that there is: "the elephant" in a warehouse.

A clause is grounded in the best of what there is, however bad that is. So before the search, each
noun for what is handled or gone to is compared with the labels of all things and the names of all
places (:mod:`g3.language.similarity.presence`). A noun that only says which thing is meant ("the
pallet by the wall") is let pass: the pallet is there.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from g3.groundings import Context
from g3.inference.problem.command_tree import Tree
from g3.language.lexicon.field_words import bare
from g3.language.similarity.learned_lexicon import Lexicon
from g3.language.similarity.presence import best_naming, is_called, least_alike, may_be_absent

SHOWN = 8
"""At most so many sorts of things are listed."""
_NUMBERS = ("no", "a", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def absent_nouns(tree: Tree, context: Context, lexicon: Lexicon | None = None) -> tuple[str, ...]:
    """Return the nouns of a command that name nothing in a world.

    Parameters
    ----------
    tree
        The command's clauses.
    context
        The world.
    lexicon
        Words and labels that a model has learned.
    """
    present = how_present(tree, context, lexicon)
    return tuple(noun for noun, naming in present.items() if naming < least_alike())


def how_present(tree: Tree, context: Context, lexicon: Lexicon | None = None) -> dict[str, float]:
    """Return the presence of each noun that may be absent from a world, from 0 to 1."""
    robot = context.agent.labels
    seen = [o.labels for o in context.objects if o.id != context.agent_id]
    seen += [(place.name,) for place in context.places if place.name]
    return {
        noun: 1.0 if is_called(noun, robot) else best_naming(noun, seen, lexicon)
        for noun in asked_nouns(tree)
        if may_be_absent(noun)
    }


def asked_nouns(tree: Tree) -> Iterator[str]:
    """Return the nouns of handled things and goals, in lower case, but not their neighbours'."""
    within = {
        node
        for parent, sdc in enumerate(tree.nodes)
        if sdc.type == "OBJECT"
        for field in ("l", "l2")
        for child in tree.children[parent].get(field, ())
        for node in tree.all_below(child)
    }
    ends = {noun[-1].start for noun in tree.nouns}
    for node, sdc in enumerate(tree.nodes):
        if (
            sdc.type == "OBJECT"
            and sdc.words
            and node not in within
            and sdc.words[-1].start in ends
        ):
            yield bare(sdc.words[-1].text)


def what_is_missing(nouns: tuple[str, ...], context: Context) -> str:
    """Answer a command about a thing that isn't there.

    >>> what_is_missing(("elephant", "truck"), Context("empty", (), (), "robot"))
    'I see no elephant and no truck here. There is nothing else here'
    """
    missing = " and ".join(f"no {noun}" for noun in nouns)
    return f"I see {missing} here. {_what_there_is(context)}"


def _what_there_is(context: Context) -> str:
    things = Counter(o.labels for o in context.objects if o.id != context.agent_id)
    sorts = [_counted(" ".join(labels), count) for labels, count in things.items()]
    sorts += dict.fromkeys(place.name for place in context.places if place.name)
    if not sorts:
        return "There is nothing else here"
    more = " and more" if len(sorts) > SHOWN else ""
    return f"There are: {', '.join(sorts[:SHOWN])}{more}"


def _counted(name: str, count: int) -> str:
    """Count things by their labels: "two tire pallets"."""
    if count == 1:
        return f"an {name}" if name[:1] in "aeiou" else f"a {name}"
    number = _NUMBERS[count] if count < len(_NUMBERS) else str(count)
    return f"{number} {_plural(name)}"


def _plural(name: str) -> str:
    if name.endswith("person"):
        return name.removesuffix("person") + "people"
    if name.endswith("shelf"):
        return name.removesuffix("f") + "ves"
    return (
        name if name.endswith("s") else name + ("es" if name.endswith(("x", "ch", "sh")) else "s")
    )
