"""What single potentials add to scores, for tests."""

import numpy as np

import g3.inference  # noqa: F401 - fills the catalogue
from g3.actions.robot_state import start_state
from g3.groundings import Context
from g3.inference.potentials.cases import ActionCase, CandidateCase, FactorCase
from g3.inference.potentials.potential_registry import added_by, potentials
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.grounding_problem import Arguments, GroundingProblem
from g3.inference.problem.packed_scene import scene_of
from g3.learning.examples import to_batch
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.features.scenes import row
from tests.g3.inference.constant_cost import ConstantCost
from tests.worlds import robot, scene

WEIGHT = {own.name: own.weight for own in potentials()}


def tree_of(notation):
    """The clauses of a command that is written in brackets."""
    return Tree(parse_brackets(notation))


def adds(name, case):
    return added_by(case).get(name, np.zeros(case.shape))


def problem_in(context, **options):
    state = start_state(context)
    return GroundingProblem(state, scene_of(state.context), ConstantCost(), **options)


EMPTY = problem_in(Context("empty", (robot(),), (), "robot"))


def of_rows(name, batch, notation="OBJ(f = it)", problem=EMPTY):
    """What a potential adds to rows of a factor, of things that are one each."""
    tree = tree_of(notation)
    return adds(name, FactorCase(tree, 0, batch, problem, [1] * len(batch)))


def of_examples(name, world, kind, figures, notation="OBJ(f = it)", **roles):
    """What a potential adds to a factor, by what its figure may be.

    Parameters
    ----------
    roles
        The words of the clause and its landmark, as :func:`tests.g3.features.scenes.row` has them.
    """
    return of_rows(name, to_batch([row(world, kind, f, **roles) for f in figures]), notation)


def of_sides(things, agent, words, relation="", landmark=()):
    """What sides, numbers and the middle add to an OBJECT, by the things that it may be."""
    roles = {"words": words, "relation": relation, "landmark": landmark}
    world = scene(*things, agent=agent)
    names = ("side", "ordinal", "middle")
    return sum(of_examples(name, world, "OBJECT", things, **roles) for name in names)


def of_things(name, things, notation, landmark=None, **options):
    """What a potential adds to an OBJECT, by the things of a context that it may be."""
    problem = problem_in(Context("scene", (*things, robot()), (), "robot"), **options)
    tree = tree_of(notation)
    bodies, index = problem.scene.indices([*((t,) for t in things), landmark or (things[0],)])
    n = len(things)
    batch = problem.scene.batch(
        "OBJECT",
        [tree.words[0]],
        np.zeros(n, dtype=np.intp),
        bodies,
        figure=index[:n],
        landmark=np.full(n, index[n] if landmark else -1),
    )
    return adds(name, FactorCase(tree, 0, batch, problem, [1] * n))


def of_groups(name, notation, groups, problem):
    """What a potential adds to groups that a noun may name."""
    tree = tree_of(notation)
    return adds(name, CandidateCase(tree, 0, problem, groups, "figure", 0))


def of_actions(name, notation, actions, found=None, problem=EMPTY, **options):
    """What a potential adds to actions for a clause."""
    tree = tree_of(notation)
    found = found or Arguments((None,), (None,), -1, {})
    case = ActionCase(tree, 0, problem.state, found, actions, problem)
    return adds(name, case)
