"""Actions that are tried for a clause, as batches of its EVENT's and its PATHs' factors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions.action_kinds import Action, move
from g3.actions.motions import Motions
from g3.actions.robot_state import State
from g3.features.bodies import Bodies, IntArray
from g3.features.factor_batch import FactorBatch
from g3.groundings import FloatArray, PhysicalObject
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.costs import Cost
from g3.inference.problem.grounding_problem import Arguments, Candidate
from g3.inference.problem.packed_scene import Scene, carried_bodies, join, moving_bodies, scene_of
from g3.inference.search.arguments import Rows, current
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class Stage:
    """The bodies of a state with the robot's motions and the loads they move.

    Parameters
    ----------
    scene
        The state's things.
    bodies
        They, then the motions, then the loads as each motion moves them.
    motions
        The motions.
    first_motion
        Index of the first of them.
    """

    scene: Scene
    bodies: Bodies
    motions: Motions
    first_motion: int

    def themes(self, motion: IntArray, theme: IntArray) -> IntArray:
        """Return the bodies of themes (n,), as the motions (n,) move them."""
        n = len(self.motions)
        moved = (self.motions.load[motion] == theme) & (theme >= 0)
        return np.where(moved, self.first_motion + n + motion, theme)


def stage_of(scene: Scene, motion: Motions, bodies: Bodies) -> Stage:
    """Put motions, and the loads that they move, behind the bodies of a scene."""
    first = len(bodies.z_min)
    load = np.maximum(motion.load, 0)
    everything = join(
        bodies,
        moving_bodies(motion.xyz, motion.yaw, motion.t, scene.bodies),
        carried_bodies(load, motion.load_xyz, motion.load_yaw, motion.t, scene.bodies),
    )
    return Stage(scene, everything, motion, first)


@short_repr
@dataclass(frozen=True, slots=True)
class Trial:
    """The actions that are tried for a top-level clause in a state.

    Parameters
    ----------
    tree, root
        The clause.
    state
        The state in which the actions begin.
    found
        Candidates of the clause's arguments.
    actions
        The actions.
    rows
        Combinations of actions, themes and goals that are tried.
    scene
        The state's things packed, where they are already.
    """

    tree: Tree
    root: int
    state: State
    found: Arguments
    actions: Sequence[Action]
    rows: Rows
    scene: Scene | None = None


def event_batch(trial: Trial) -> tuple[FactorBatch, Stage, dict[int, IntArray]]:
    """Return the batch of an EVENT's factor, and the bodies of PATH landmarks by node."""
    state, found, rows = trial.state, trial.found, trial.rows
    actions = trial.actions
    scene = trial.scene or scene_of(state.context)
    groups = [current(c.group, state) for c in found.goals if c is not None]
    marks = {p: [current(c.group, state) for c in cs if c] for p, cs in found.paths.items()}
    flat = [g for group in marks.values() for g in group]
    bodies, index = scene.indices([*groups, *flat])
    goal = np.append(index[: len(groups)], -1)[rows.goal]
    ends = len(groups) + np.cumsum([0, *(len(m) for m in marks.values())])
    places = {p: index[a:b] for p, a, b in zip(marks, ends, ends[1:], strict=False)}
    ids = {o.id: i for i, o in enumerate(state.context.objects)}
    agent = state.context.agent_id

    def body(c: Candidate | None) -> int:
        if c is None or not isinstance(c.group[0], PhysicalObject) or c.group[0].id == agent:
            return -1
        return ids[c.group[0].id]

    named = np.array([*(body(c) for c in found.themes), -1], dtype=np.intp)
    motion = move(state, actions)
    stage = stage_of(scene, motion, bodies)
    # Where a clause names no object, it is about what the action moves.
    implied = np.where(found.themes == (None,), motion.load[rows.action], named[rows.theme])
    batch = scene.batch(
        "EVENT",
        [trial.tree.words[trial.root]],
        np.zeros(len(rows.action), dtype=np.intp),
        stage.bodies,
        figure=stage.first_motion + rows.action,
        theme=stage.themes(rows.action, implied),
        goal=goal,
    )
    return batch, stage, places


@short_repr
@dataclass(frozen=True, slots=True)
class PathFactor:
    """The factor of a PATH in a clause that actions are tried for.

    Parameters
    ----------
    tree, path
        The PATH.
    stage
        The actions' bodies.
    cost
        Scores it.
    """

    tree: Tree
    path: int
    stage: Stage
    cost: Cost

    def scores(self, figure: IntArray, landmark: IntArray) -> FloatArray:
        """Return log-probabilities of motions and landmarks, each pair scored once; shape (n,)."""
        pairs, row = np.unique(np.column_stack((figure, landmark)), axis=0, return_inverse=True)
        batch = self.batch(pairs[:, 0], pairs[:, 1])
        found: FloatArray = self.cost.log_probability(batch)[row.reshape(-1)]
        return found

    def batch(self, figure: IntArray, landmark: IntArray) -> FactorBatch:
        """Return the batch of motions (n,) with landmarks (n,)."""
        return path_batch(self.tree, self.path, self.stage, figure, landmark)

    def best(
        self, bodies: IntArray, candidates: Sequence[Candidate | None], other_scores: FloatArray
    ) -> tuple[FloatArray, IntArray]:
        """Return the best landmark of each action, with the scores of both; shape (actions,).

        Parameters
        ----------
        other_scores
            Other scores of each action with each landmark, shape (actions, candidates).
        """
        n, m = len(self.stage.motions), len(bodies)
        motion = self.stage.first_motion + np.arange(n)
        if not m:
            none = np.full(n, -1, dtype=np.intp)
            return self.scores(motion, none), np.zeros(n, dtype=np.intp)
        own = self.scores(np.repeat(motion, m), np.tile(bodies, n)).reshape(n, m)
        total = own + np.array([c.score if c else 0.0 for c in candidates]) + other_scores
        which = total.argmax(axis=1)
        return total[np.arange(n), which], which


def path_batch(
    tree: Tree, path: int, stage: Stage, figure: IntArray, landmark: IntArray
) -> FactorBatch:
    """Return the batch of a PATH's factor for motions and landmarks, shape (n,)."""
    return stage.scene.batch(
        "PATH",
        [tree.words[path]],
        np.zeros(len(figure), dtype=np.intp),
        stage.bodies,
        figure=figure,
        landmark=landmark,
    )
