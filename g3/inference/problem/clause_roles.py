"""Roles of the clauses inside a top-level clause: theme, source and goal."""

from __future__ import annotations

from g3.inference.problem.command_tree import Tree
from g3.inference.problem.phrases import (
    is_measure,
    is_pronoun,
    is_singled_out,
    names_forks,
    names_lift,
    names_robot,
)
from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import BESIDE, SIDES, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words, normalise
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_classes import HANDLING_VERBS
from g3.sdc.clauses import SDC, Field, all_words

_ARGUMENTS: tuple[Field, ...] = ("l", "l2")


def is_source(sdc: SDC) -> bool:
    """Check that a PATH or a PLACE tells where something is taken from: "off the truck"."""
    said = field_words(sdc.relation)
    named = concepts(said)
    emptied = sdc.type == "PATH" and said == ("of",)  # "clear it of crates"
    aside = "from" in said and SIDES & concepts(said[: said.index("from")])  # "left from the cone"
    return emptied or ("from" in named and "to" not in named and not aside)


def is_company(path: SDC) -> bool:
    """Check that a PATH tells what goes along: "with the pallet"."""
    return bare_words(path.relation) == ["with"]


def is_goal(path: SDC) -> bool:
    """Check that a PATH says where it leads: "to the truck"."""
    return "to" in concepts(field_words(path.relation))


def tells_place(path: SDC) -> bool:
    """Check that a PATH tells where something is to be put as a PLACE does: "beside the crate"."""
    return bool(path.landmark1) and bool(BESIDE & concepts(field_words(path.relation)))


def names_again(tree: Tree, node: int) -> bool:
    """Check that a clause names by its kind what an earlier one named: "the truck", "its bed"."""
    return node in tree.once(_named_again)


def _named_again(tree: Tree) -> frozenset[int]:
    found: list[int] = []
    said: set[str] = set()
    for root in range(len(tree.sdcs)):
        below = [n for n in tree.all_below(root) if tree.nodes[n].type == "OBJECT"]
        leaves = [n for n in below if tree.nodes[n].words and not is_pronoun(tree.nodes[n])]
        more = {n for own in below for n in tree.children[own].get("f", ())}
        nouns = {n: normalise(bare(tree.nodes[n].words[-1].text)) for n in leaves}
        for n in leaves:
            first = bare(tree.nodes[n].words[0].text)
            own = first in WORDS["owners"] or nouns[n] in WORDS["decks"]
            known = own or (first not in WORDS["indefinite"] and nouns[n] in said)
            if said and known and n not in more and not is_singled_out(tree.nodes[n]):
                found.append(n)
        said.update(nouns.values())
    return frozenset(found)


def objects(tree: Tree, root: int) -> list[int]:
    """OBJECTs that a clause handles or comes to, what is handled first.

    "The boxes should be on the trailer" handles the boxes. A pronoun beside what it stands for is
    no other thing: "the boxes, lift them"; but "it and the boxes" are two.
    """
    arguments = tree.below(root, _ARGUMENTS, "OBJECT")
    found = [n for n in arguments if not is_measure(tree.nodes[n])]
    others = [n for n in found if not stands_for_other(tree.nodes[n])]
    first = [n for n in found[:1] if not others or _are_joined(tree, n, others[0])]
    return [*subjects(tree, root), *dict.fromkeys((*first, *others))]


def _are_joined(tree: Tree, node: int, after: int) -> bool:
    """Check that "and" stands between an OBJECT and one with a noun."""
    if not noun_leaf(tree.nodes[after]).words:
        return False  # "it parallel and [a bit closer to the trailer]"
    one, other = all_words(tree.nodes[node])[-1], all_words(tree.nodes[after])[0]
    return "and" in tree.text[one.end : other.start].lower().split()


def landmark_nodes(tree: Tree, node: int) -> list[int]:
    """OBJECTs and PLACEs that a clause's relation leads to, or those of the PATHs in it."""
    below = tree.below(node, _ARGUMENTS, "OBJECT", "PLACE")
    found = [n for n in below if not is_measure(tree.nodes[n])]
    paths = tree.below(node, _ARGUMENTS, "PATH")
    return found or [n for p in paths for n in tree.below(p, _ARGUMENTS, "OBJECT", "PLACE")]


def stands_for_other(sdc: SDC) -> bool:
    """Check that an OBJECT is nothing but a word for what was named: "it", "those"."""
    words = bare_words(sdc.words)
    return len(words) == 1 and words[0] in WORDS["pronouns"]


def subjects(tree: Tree, root: int) -> list[int]:
    """Return the things that are or go somewhere, if not the robot; not those who handle a thing.

    In "the boxes, lift them" they are one.
    """
    verb = tree.verbs[root]
    others = [tree.nodes[n] for n in tree.below(root, _ARGUMENTS, "OBJECT")]
    acts = bool(verb.classes) or verb.is_open
    if acts and not all(is_measure(other) or is_pronoun(other) for other in others):
        return []
    return [n for n in tree.below(root, ("f",), "OBJECT") if not names_robot(tree.nodes[n])]


def goal_places(tree: Tree, root: int) -> list[int]:
    """PLACEs that tell together where an EVENT leads."""
    places = tree.below(root, _ARGUMENTS, "PLACE")
    return [n for n in places if not (is_source(tree.nodes[n]) or _leaves_out(tree, n))]


def _leaves_out(tree: Tree, node: int) -> bool:
    """Check that a clause says nothing but what is ruled out: "other than the crate"."""
    marks = tree.below(node, _ARGUMENTS, "OBJECT")
    where = concepts(field_words(tree.nodes[node].relation)) - {"from"}
    return bool(marks) and not where and tree.left_alone[0].issuperset(marks)


def goal_paths(tree: Tree, root: int) -> list[int]:
    """PATHs of an EVENT that may tell where it leads, those with "to" first.

    "Past the crates to the truck" leads to the truck.
    """
    paths = tree.below(root, _ARGUMENTS, "PATH")
    found = [p for p in paths if not is_source(tree.nodes[p]) and not is_company(tree.nodes[p])]
    found = [p for p in found if not _leaves_out(tree, p)]
    return sorted(found, key=lambda p: not is_goal(tree.nodes[p]))


def goal_within(tree: Tree, root: int) -> int | None:
    """The PLACE or OBJECT that another clause says is come to: "until you reach the truck"."""
    for event in tree.below(root, _ARGUMENTS, "EVENT"):
        if WORDS["until"].intersection(bare_words(all_words(tree.nodes[event]))):
            ends = [n for n in tree.all_below(event) if _can_be_reached(tree.nodes[n])]
            return min(ends, key=lambda n: tree.nodes[n].type != "PLACE", default=None)
    return None


def _can_be_reached(sdc: SDC) -> bool:
    return sdc.type in ("OBJECT", "PLACE") and not sdc.is_implicit and not names_robot(sdc)


def ways(tree: Tree, root: int) -> list[int]:
    """PATHs of a clause, and PLACEs from which something is taken."""
    places = tree.below(root, _ARGUMENTS, "PLACE")
    sources = [n for n in places if is_source(tree.nodes[n])]
    return [*tree.below(root, _ARGUMENTS, "PATH"), *sources]


def names_own_forks(tree: Tree, root: int) -> bool:
    """Check that a clause is about the robot's forks: "lower the forks", "raise your forklift"."""
    named = [tree.nodes[n] for n in tree.below(root, _ARGUMENTS, "OBJECT")]
    words = set(bare_words(tree.nodes[root].relation))
    lifts = bool(words & (WORDS["raising"] | WORDS["lowering"]))
    return any(names_forks(sdc) or (lifts and names_lift(sdc)) for sdc in named)


def told_ways(tree: Tree, root: int) -> frozenset[str]:
    """Ways that a clause names, it or what in it has no landmark but who is spoken to."""
    said = set(field_words(tree.nodes[root].relation))
    for node in tree.below(root, _ARGUMENTS, "PATH", "PLACE"):
        marks = tree.nodes[node].landmark1
        own = {bare(word.text) for mark in marks for word in mark.words}
        if not marks or WORDS["you"].intersection(own):
            said.update(field_words(all_words(tree.nodes[node])))
    around: frozenset[str] = frozenset(("around",) if WORDS["around"].intersection(said) else ())
    return (concepts(said) & SIDES) | around


def handled_nodes(tree: Tree) -> frozenset[int]:
    """OBJECTs that name what a clause handles, with those in them that say less of it."""
    roots = (n for n, verb in enumerate(tree.verbs) if verb.classes & HANDLING_VERBS)
    return _with_figures(tree, [n for root in roots for n in objects(tree, root)[:1]])


def told_standing(tree: Tree) -> frozenset[int]:
    """OBJECTs of which more words say what they stand on: "the left one on the truck"."""
    found: list[int] = []
    for node, sdc in enumerate(tree.nodes):
        said = concepts(field_words(sdc.relation))
        if sdc.type == "OBJECT" and "on" in said and not said & SIDES and sdc.landmark1:
            found += tree.children[node].get("f", ())
        if "taking" in tree.verbs[node].classes and any(
            is_source(tree.nodes[way]) and tree.nodes[way].landmark1 for way in ways(tree, node)
        ):
            found += objects(tree, node)[:1]
    return _with_figures(tree, found)


def _with_figures(tree: Tree, nodes: list[int]) -> frozenset[int]:
    """OBJECTs, and all that their figures are made of."""
    found = list(nodes)
    for node in found:
        found += tree.children[node].get("f", ())
    return frozenset(found)
