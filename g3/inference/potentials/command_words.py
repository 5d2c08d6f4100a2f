"""What all words of a command say of the load that it is about."""

from __future__ import annotations

import numpy as np

from g3.groundings import PhysicalObject
from g3.inference.potentials.cases import CandidateCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import objects, spares
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Scorer
from g3.inference.problem.loads_of_state import loads_of, words_of
from g3.inference.problem.phrases import verb_class
from g3.language.discourse.negation import negated
from g3.language.lexicon.word_sets import HANDLING_VERBS
from g3.learning.load_choice import LoadChoice


@potential("command-words", kind="argument", types=("EVENT",), roles=("theme",), weight=-1.0)
def command_words(case: CandidateCase) -> Measured:
    """What is handled first is the load that all words of the command tell, as learned."""
    cost, problem = case.problem.cost, case.problem
    if not isinstance(cost, Scorer) or cost.model.load_chooser_ is None or problem.held is not None:
        return False
    if case.within != first_handling(case.tree):
        return False
    loads = loads_of(problem.state)
    if len(loads) < 2:
        return False
    choice = LoadChoice(words_of(case.tree), tuple(loads.values()))
    score = cost.model.load_chooser_.log_probability(choice)
    behind = dict(zip(loads, (score.max() - score).tolist(), strict=True))
    most = max(behind.values())

    def measure(group: tuple[object, ...]) -> float:
        own = [behind.get(g.id, most) for g in group if isinstance(g, PhysicalObject)]
        return float(np.mean(own)) if own else most

    return np.array([measure(group) for group in case.groups])


def first_handling(tree: Tree) -> int | None:
    """The first top-level clause that handles something; None if none does."""
    for root, sdc in enumerate(tree.sdcs):
        verbs = HANDLING_VERBS.intersection(verb_class(sdc).split("+"))
        if sdc.type == "EVENT" and verbs and objects(tree, root):
            return None if negated(sdc) or spares(tree, root, None) else root
    return None
