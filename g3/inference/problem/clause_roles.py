"""What parts the clauses inside a top-level clause play: what is handled, whence and where to."""

from __future__ import annotations

from g3.inference.problem.command_tree import Tree
from g3.inference.problem.phrases import (
    is_measure,
    is_pronoun,
    names_forks,
    names_lift,
    names_robot,
    verb_class,
)
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, field_words
from g3.language.lexicon.word_sets import (
    BESIDE,
    FILLING,
    HANDLING_VERBS,
    LEAVING,
    LOWERING,
    RAISING,
    UNTIL,
    YOU,
)
from g3.sdc.clauses import SDC, Field, all_words

_ARGUMENTS: tuple[Field, ...] = ("l", "l2")


def is_source(sdc: SDC) -> bool:
    """Whether a PATH or a PLACE tells where something is taken from: "off the truck"."""
    named = concepts(field_words(sdc.relation))
    return "from" in named and "to" not in named


def is_company(path: SDC) -> bool:
    """Whether a PATH tells what goes along: "with the pallet"."""
    return [bare(word.text) for word in path.relation] == ["with"]


def is_goal(path: SDC) -> bool:
    """Whether a PATH says where it leads: "to the truck"."""
    return "to" in concepts(field_words(path.relation))


def tells_place(path: SDC) -> bool:
    """Whether a PATH tells where something is to be put as a PLACE does: "beside the crate"."""
    return bool(path.landmark1) and bool(BESIDE & concepts(field_words(path.relation)))


def objects(tree: Tree, root: int) -> list[int]:
    """OBJECTs that a clause handles or comes to, what is handled first.

    "The boxes should be on the trailer" handles the boxes, and "load the truck with the tires" the
    tires.
    """
    arguments = tree.below(root, _ARGUMENTS, "OBJECT")
    found = [n for n in arguments if not is_measure(tree.nodes[n])]
    words = {bare(word.text) for word in tree.nodes[root].relation}
    if len(found) == 2 and "with" in words and words & FILLING:
        found = found[::-1]
    return [*subjects(tree, root), *found]


def landmark_nodes(tree: Tree, node: int) -> list[int]:
    """OBJECTs and PLACEs that a clause's relation leads to, or those of the PATHs in it."""
    below = tree.below(node, _ARGUMENTS, "OBJECT", "PLACE")
    found = [n for n in below if not is_measure(tree.nodes[n])]
    paths = tree.below(node, _ARGUMENTS, "PATH")
    return found or [n for p in paths for n in tree.below(p, _ARGUMENTS, "OBJECT", "PLACE")]


def subjects(tree: Tree, root: int) -> list[int]:
    """Who or what does something or is somewhere, if not the robot."""
    return [n for n in tree.below(root, ("f",), "OBJECT") if not names_robot(tree.nodes[n])]


def goal_places(tree: Tree, root: int) -> list[int]:
    """PLACEs that tell together where an EVENT leads."""
    return [n for n in tree.below(root, _ARGUMENTS, "PLACE") if not is_source(tree.nodes[n])]


def goal_paths(tree: Tree, root: int) -> list[int]:
    """PATHs of an EVENT that may tell where it leads, those with "to" first.

    "Past the crates to the truck" leads to the truck.
    """
    paths = tree.below(root, _ARGUMENTS, "PATH")
    found = [p for p in paths if not is_source(tree.nodes[p]) and not is_company(tree.nodes[p])]
    return sorted(found, key=lambda p: not is_goal(tree.nodes[p]))


def goal_within(tree: Tree, root: int) -> int | None:
    """The PLACE or OBJECT that another clause says is come to: "until you reach the truck"."""
    for event in tree.below(root, _ARGUMENTS, "EVENT"):
        if UNTIL.intersection(bare(word.text) for word in all_words(tree.nodes[event])):
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


def leaves_open(tree: Tree, root: int) -> bool:
    """Whether a clause puts something down without saying where: where the robot was sent."""
    places = "placing" in verb_class(tree.nodes[root])
    return places and not tree.below(root, _ARGUMENTS, "PLACE", "PATH")


def spares(tree: Tree, root: int, held: str | None) -> bool:
    """Whether a clause tells what to leave alone: "leave the crate", with nothing on the forks.

    But not "leave it there", or on the truck.
    """
    words = {bare(word.text) for word in tree.nodes[root].relation}
    if not words & LEAVING:
        return False
    places = tree.below(root, _ARGUMENTS, "PLACE")
    return "alone" in words or (held is None and not places)


def names_own_forks(tree: Tree, root: int) -> bool:
    """Whether a clause is about the robot's forks: "lower the forks", "raise your forklift"."""
    named = [tree.nodes[n] for n in tree.below(root, _ARGUMENTS, "OBJECT")]
    words = {bare(word.text) for word in tree.nodes[root].relation}
    lifts = bool(words & (RAISING | LOWERING))
    return any(names_forks(sdc) or (lifts and names_lift(sdc)) for sdc in named)


def is_put_later(tree: Tree, root: int) -> bool:
    """Whether a later clause puts something down, whatever it is."""
    return _later_putting(tree, root) is not None


def is_itself_put_later(tree: Tree, root: int) -> bool:
    """Whether a later clause puts down what is spoken of now: "set it down"."""
    later = _later_putting(tree, root)
    if later is None:
        return False
    themes = tree.below(later, _ARGUMENTS, "OBJECT")
    return not themes or is_pronoun(tree.nodes[themes[0]])


def _later_putting(tree: Tree, root: int) -> int | None:
    later = range(root + 1, len(tree.sdcs))
    return next((n for n in later if "placing" in verb_class(tree.nodes[n])), None)


def told_side(tree: Tree, root: int) -> str:
    """The side that the robot has been told to go to when a clause begins, or is in it.

    "Swing left and proceed to the truck" speaks of a truck on the left. What something is picked
    up from or put down at tells nothing of the next thing.
    """
    found = ""
    for node in range(root + 1):
        verb = set(verb_class(tree.nodes[node]).split("+"))
        if node < root and verb & HANDLING_VERBS:
            found = ""
        if tree.nodes[node].type == "EVENT" and (node == root or verb & {"going", "turning"}):
            named = _own_words(tree, node) & {"left", "right"}
            found = named.pop() if len(named) == 1 else found
    return found


def _own_words(tree: Tree, root: int) -> set[str]:
    """Concepts of an EVENT and of what in it has no landmark but who is spoken to."""
    said: set[str] = set(concepts(field_words(tree.nodes[root].relation)))
    for node in tree.below(root, ("l", "l2"), "PATH", "PLACE"):
        marks = [w.text.lower() for mark in tree.nodes[node].landmark1 for w in all_words(mark)]
        if not marks or YOU.intersection(marks):
            said |= concepts(field_words(all_words(tree.nodes[node])))
    return said
