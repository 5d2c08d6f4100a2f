"""Amounts that clauses state: of going, of turning, of moving the forks, of waiting."""

from __future__ import annotations

from g3.actions.action_kinds import Amounts
from g3.inference.problem.clause_roles import is_source, names_own_forks
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import frame
from g3.inference.problem.phrases import is_measure, names_forks, names_lift, names_robot
from g3.language.lexicon.field_words import bare
from g3.language.lexicon.measures import metres_said, radians_said, seconds_said
from g3.sdc.clauses import all_words


def amounts_said(tree: Tree, root: int) -> Amounts:
    """The amounts of a clause that only goes, turns or moves the forks.

    It names no thing but one that it leaves: "back up three metres from the truck".
    """
    return tree.once(_amounts_said, root)


def _amounts_said(tree: Tree, root: int) -> Amounts:
    if tree.nodes[root].type != "EVENT":
        return Amounts()
    said = [bare(word.text) for word in sorted(all_words(tree.nodes[root]), key=lambda w: w.start)]
    classes = frame(tree, root).classes
    if "staying" in classes and not frame(tree, root).objects:
        return Amounts(seconds=seconds_said(said))
    parts = tree.below(root, ("l", "l2"), "OBJECT", "PLACE", "PATH", "EVENT")
    parts = [part for part in parts if not is_source(tree.nodes[part])]
    below = [tree.nodes[n] for part in parts for n in tree.all_below(part)]
    named = [sdc for sdc in below if sdc.type == "OBJECT" and sdc.words]
    own = (is_measure, names_robot, names_forks, names_lift)
    if not all(any(f(sdc) for f in own) for sdc in named):
        return Amounts()
    if names_own_forks(tree, root):
        return Amounts(metres=metres_said(said))
    if not classes or classes - {"going", "turning"}:
        return Amounts()
    return Amounts(metres_said(said), radians_said(said) if "turning" in classes else None)
