"""Execution of scripts in physics: a simulation that watches its contacts, and its report.

Behaviours move the simulation as a :class:`~corpus_tools.world.physics.behaviours.Robot`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np
import numpy.typing as npt

from corpus_tools.world.physics import forklift_behaviours  # noqa: F401 - they register
from corpus_tools.world.physics.behaviours import (
    ActionError,
    Goal,
    Load,
    argument_text,
    behave,
    load_of,
    script_arguments,
    step_text,
)
from corpus_tools.world.physics.build import TIMESTEP_S, World, body_name, build_world, ground_of
from corpus_tools.world.physics.pacing import EMPTY, LIFT, LOADED, Limits, ramp, references
from corpus_tools.world.planning.curves import Way
from corpus_tools.world.state.dimensions import LIFT_RANGE, LOW
from corpus_tools.world.state.forklift_parts import DRIVE_RATE, FORKS, LIFT_RATE, TURN_RATE
from corpus_tools.world.state.recording import NS_PER_S, Recording, Step, heading, upright
from corpus_tools.world.state.robot_script import ACTIONS, Script, ScriptStep
from corpus_tools.world.state.shapes import Shape, shape_of
from corpus_tools.world.state.start import moved, starting
from g3.actions.logged_actions import loaded
from g3.errors import CorpusError
from g3.geometry.plane import wrap
from g3.geometry.relations import in_frame
from g3.groundings import Context, FloatArray, Place, Trajectory
from g3.short_repr import short_repr

SLIP_M = 0.10
"""A load that moves this far on the forks is lost."""
SETTLE_S = 1.0
PUSHED_M = 0.05
"""Shift of a thing while everything settles, in metres, above which it began inside another."""
STILL_M = 1e-3
"""Largest motion of a still thing, in metres; twice as many radians for turns."""
SLEEP_M_S = 1e-3
"""Speed below which a thing falls asleep, in m/s."""
TILT = np.deg2rad(5.0)
"""A load that leans more isn't upright."""

_CHASSIS, _GROUND = -2, -1
"""Owners of geoms that belong to no object, or to the robot's chassis."""
_RATES = np.array([DRIVE_RATE, DRIVE_RATE, TURN_RATE, LIFT_RATE])

NEAR_M = 0.15
NEAR_DEG = 5.0
"""Largest distance of a load or the robot from its goal, in metres and in degrees."""
DISPLACED_M = 0.1
"""Largest displacement of things that no step was to move, in metres."""
PAUSE_S = 1.0
"""The world stands still so long before the first and after the last step."""


@short_repr
@dataclass(slots=True, eq=False)
class Simulation:
    """A world in motion: its physics, and the samples that its recording is made of."""

    world: World
    data: mujoco.MjData
    start: Context
    sample_every: int
    rate_hz: float
    load: Load | None = None
    grip: str | None = None
    """Id of the object that the forks may touch."""
    support: str | None = None
    """Id of the object that the load on the forks may touch, apart from them and the ground."""
    handled: set[str] = field(default_factory=set)
    """Ids of objects that have been on the forks."""
    samples: list[FloatArray] = field(default_factory=list)
    """Joint coordinates at every moment of the recording."""
    _owner: npt.NDArray[np.int64] = field(init=False)
    _steps: int = 0

    def __post_init__(self) -> None:
        self._owner = _owners(self.world)
        self._sample()

    @property
    def time_s(self) -> float:
        """Seconds of simulated time since the start."""
        return self._steps / (self.sample_every * self.rate_hz)

    @property
    def pose(self) -> FloatArray:
        """Pose of the robot, shape (3,)."""
        pose: FloatArray = self.data.qpos[self.world.drive_qpos].copy()
        return pose

    @property
    def forks_m(self) -> float:
        """Height of the forks, in metres."""
        return float(self.data.qpos[self.world.forks_qpos])

    @property
    def ground_m(self) -> float:
        """Height of the ground."""
        return ground_of(self.start)

    def index(self, thing: str) -> int:
        """Return the index of an object among all objects."""
        return next(i for i, item in enumerate(self.start.objects) if item.id == thing)

    def shape(self, thing: str) -> Shape:
        """Return the box of an object."""
        return shape_of(self.start.objects[self.index(thing)])

    def body_pose(self, thing: str) -> tuple[FloatArray, FloatArray]:
        """Return the position (3,) and orientation (4,) of an object."""
        i = self.index(thing)
        position, orientation = _states(self.world, self.data.qpos[None])
        return position[0, i], orientation[0, i]

    def lean(self, thing: str) -> float:
        """Return the lean of an object, in radians."""
        _, (_, x, y, _) = self.body_pose(thing)
        return float(2 * np.arcsin(min(np.hypot(x, y), 1.0)))

    def take(self, thing: str) -> None:
        """Note that an object is on the forks, where it is now."""
        self.handled.add(thing)
        self.load = load_of(self, thing)

    def drive(self, way: Way, limits: Limits | None = None) -> None:
        """Drive a way that starts at the robot's pose."""
        if limits is None:
            limits = EMPTY if self.load is None else LOADED
        start: FloatArray = self.data.ctrl[:3].copy()
        poses = references(start, way, limits, self._timestep)
        self._run(np.column_stack((poses, np.full(len(poses), self.data.ctrl[3]))))

    def lift(self, to_m: float) -> None:
        """Bring the forks to a height above their lowest."""
        heights = ramp(float(self.data.ctrl[3]), to_m, LIFT, self._timestep)
        self._run(np.column_stack((np.tile(self.data.ctrl[:3], (len(heights), 1)), heights)))

    def wait(self, duration_s: float) -> None:
        """Stand still."""
        self._run(np.tile(self.data.ctrl, (max(round(duration_s / self._timestep), 1), 1)))

    def recording(self) -> Recording:
        """Return the recording up to now."""
        joints = np.array(self.samples)
        position, orientation = _states(self.world, joints)
        # Solvers leave a shiver of some micrometres in what stands still.
        still = np.abs(position - position[0]).max(axis=(0, 2)) < STILL_M
        still &= np.abs(orientation - orientation[0]).max(axis=(0, 2)) < STILL_M
        position[:, still], orientation[:, still] = position[0, still], orientation[0, still]
        t_ns = np.round(np.arange(len(self.samples)) * (NS_PER_S / self.rate_hz))
        return Recording(
            self.start,
            t_ns.astype(np.int64),
            position,
            orientation,
            LOW + joints[:, self.world.forks_qpos],
        )

    @property
    def _timestep(self) -> float:
        return float(self.world.model.opt.timestep)

    def _run(self, targets: FloatArray) -> None:
        """Follow joint positions, one row (4,) a timestep, and come to rest at the last."""
        speed = np.gradient(targets, self._timestep, axis=0) if len(targets) > 1 else 0 * targets
        gain = np.gradient(speed, self._timestep, axis=0) if len(targets) > 1 else 0 * targets
        # What a critically damped servo is to be told so that it follows without lag.
        controls = targets + speed * 2 / _RATES + gain / _RATES**2
        controls[-1] = targets[-1]
        for control in controls:
            self._step(control)

    def _step(self, control: FloatArray) -> None:
        self.data.ctrl[:] = control
        mujoco.mj_step(self.world.model, self.data)
        self._steps += 1
        if self._steps % self.sample_every == 0:
            self._sample()
            self._check()

    def _sample(self) -> None:
        self.samples.append(self.data.qpos.copy())

    def _check(self) -> None:
        owners = self._owner[self.data.contact.geom].tolist() if self.data.ncon else []
        for pair in {(one, other) for one, other in owners}:
            self._allow(pair)
        if self.load is not None:
            at = int(self.world.free_qpos[self.world.free == self.index(self.load.id)][0])
            xy, (_, x, y, _) = self.data.qpos[at : at + 2], self.data.qpos[at + 3 : at + 7]
            offset = in_frame(xy, self.pose) - self.load.xy
            if np.hypot(*offset) > SLIP_M or 2 * np.hypot(x, y) > TILT:
                raise ActionError(f"{self.load.id} slipped on the forks")

    def _allow(self, pair: tuple[int, int]) -> None:
        """Raise if two objects must not touch each other."""
        robot, items = self.world.robot, self.start.objects

        def name(i: int) -> str | None:
            return items[i].id if i >= 0 else None

        for mover, other in (pair, pair[::-1]):
            touched = name(other) or "the ground"
            if mover == _CHASSIS:
                raise ActionError(f"the robot ran into {touched}")
            if mover == robot and name(other) != self.grip:
                raise ActionError(f"the forks touched {touched}")
            if (
                self.load is not None
                and name(mover) == self.load.id
                and other not in (robot, _GROUND)
                and name(other) != self.support
            ):
                raise ActionError(f"{self.load.id} touched {touched}")


def simulation(
    context: Context, rate_hz: float, forks_m: float = 0.0, held: str | None = None
) -> Simulation:
    """Start a simulation of a context, sampled at a rate.

    Forks with a load are as high as the load, empty ones as high as is given.
    """
    start, held, forks = starting(context, held)
    forks = min(forks_m, LIFT_RANGE) if held is None else forks
    world = build_world(start, looks=False)
    per_sample = max(int(np.ceil(1 / (rate_hz * TIMESTEP_S) - 1e-9)), 1)
    world.model.opt.timestep = 1 / (rate_hz * per_sample)
    # Loads sleep until they are touched: they stand exactly still, and cost nothing.
    world.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    world.model.opt.sleep_tolerance = SLEEP_M_S
    data = mujoco.MjData(world.model)
    robot = start.agent.trajectory
    joints = [*robot.xyz[0, :2], robot.yaw[0], forks]
    data.qpos[[*world.drive_qpos, world.forks_qpos]] = joints
    data.ctrl[:] = joints
    settled = _settled(world, data)
    running = Simulation(world, data, settled, per_sample, rate_hz)
    if held is not None:
        running.grip = held
        running.take(held)
    return running


def _settled(world: World, data: mujoco.MjData) -> Context:
    """Let everything come to rest, and fall asleep; the context as it is then."""
    before, _ = _states(world, data.qpos[None])
    for _ in range(round(SETTLE_S / world.model.opt.timestep)):
        mujoco.mj_step(world.model, data)
    after, orientation = _states(world, data.qpos[None])
    objects = list(world.context.objects)
    for i in world.free:
        shift = after[0, i] - before[0, i]
        if np.linalg.norm(shift) > PUSHED_M:
            raise CorpusError(
                f"{objects[i].id} stands in something: it was pushed away by "
                f"{np.linalg.norm(shift):.2f} m",
                where=world.context.id,
                fix="move them apart",
            )
        item = moved(objects[i], shift)
        pose = Trajectory(item.trajectory.t, after[:, i], heading(orientation[:, i]))
        objects[i] = replace(item, trajectory=pose)
    return replace(world.context, objects=tuple(objects))


def _states(world: World, joints: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return positions (n, b, 3), orientations (n, b, 4) of all objects at coordinates (n, q)."""
    shape = len(joints), len(world.context.objects)
    position, orientation = np.empty((*shape, 3)), np.empty((*shape, 4))
    poses = joints[:, world.free_qpos[:, None] + np.arange(7)]
    position[:, world.free], orientation[:, world.free] = poses[..., :3], poses[..., 3:]
    start = [world.context.objects[i].trajectory for i in world.mocap]
    for i, pose in zip(world.mocap, start, strict=True):
        position[:, i], orientation[:, i] = pose.xyz[0], upright(pose.yaw[0])
    drive = joints[:, world.drive_qpos]
    position[:, world.robot, :2] = drive[:, :2]
    position[:, world.robot, 2] = ground_of(world.context)
    orientation[:, world.robot] = upright(drive[:, 2])
    return position, orientation


def _owners(world: World) -> npt.NDArray[np.int64]:
    """Return the object's index for every geom; the forks count as the robot, not its chassis."""
    model = world.model
    names = {body_name(item.id): i for i, item in enumerate(world.context.objects)}
    names[body_name(world.context.agent_id)] = _CHASSIS
    names[FORKS] = world.robot
    bodies = [names.get(model.body(i).name, _GROUND) for i in range(model.nbody)]
    owners: npt.NDArray[np.int64] = np.array(bodies)[model.geom_bodyid]
    return owners


@short_repr
@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a step."""

    step: ScriptStep
    goal: Goal | None
    """Goal of the step; None if it had none."""
    error_m: float = 0.0
    error_deg: float = 0.0
    """Distance from the goal at the step's end, in metres, and from its heading, in degrees."""
    lean_deg: float = 0.0
    """Lean of the moved thing, in degrees."""


@short_repr
@dataclass(frozen=True, slots=True)
class Execution:
    """Result of a script."""

    recording: Recording
    """Recording of the execution, to the end or to its failure."""
    outcomes: tuple[Outcome, ...]
    """Outcomes of the executed steps."""
    failure: ActionError | None
    """Reason why the step after those could not be executed; None if all were."""
    handled: frozenset[str] = frozenset()
    """Ids of objects that were on the forks."""
    held: str | None = None
    """Id of the object on the forks at the end."""

    @property
    def problems(self) -> tuple[str, ...]:
        """All that keeps the execution from being as the script wants it."""
        problems = [str(self.failure)] if self.failure else []
        for outcome in self.outcomes:
            if outcome.error_m > NEAR_M or outcome.error_deg > NEAR_DEG:
                problems.append(
                    f"{step_text(outcome.step)}: ended {outcome.error_m:.2f} m and "
                    f"{outcome.error_deg:.1f} degrees from its goal"
                )
            if outcome.lean_deg > np.rad2deg(TILT):
                problems.append(
                    f"{step_text(outcome.step)}: leans by {outcome.lean_deg:.0f} degrees"
                )
        return (*problems, *self._displaced())

    def _displaced(self) -> list[str]:
        start, position = self.recording.start, self.recording.position
        brought = (outcome.goal.thing for outcome in self.outcomes if outcome.goal)
        meant = {start.agent_id, loaded(start), *brought}
        if self.failure is not None:
            return []
        moved = np.linalg.norm(position[-1] - position[0], axis=1)
        return [
            f"{item.id} was displaced by {far:.2f} m"
            for item, far in zip(start.objects, moved, strict=True)
            if far > DISPLACED_M and item.id not in meant
        ]


def execute(
    context: Context,
    script: Script,
    *,
    places: Mapping[str, Place] | None = None,
    rate_hz: float = 50.0,
    forks_m: float = 0.0,
    held: str | None = None,
) -> Execution:
    """Carry out a script in a simulated world.

    The same arguments give the same recording, bit for bit. A step that can't be carried out ends
    it, and is named in the result.

    Parameters
    ----------
    context
        The world at the start; trajectories are followed only to their first pose.
    places
        By the names that the script uses; the context's places by their names if None.
    rate_hz
        Number of states a second in the recording.
    forks_m
        Height of empty forks at the start, in metres.
    held
        Id of the object on the forks at the start; if None, as the context shows.
    """
    arguments = script_arguments(context, script, places)
    sim = simulation(context, rate_hz, forks_m, held)
    sim.wait(PAUSE_S)
    steps: list[Step] = []
    outcomes: list[Outcome] = []
    failure = None
    for step, argument in zip(script, arguments, strict=True):
        began = sim.time_s
        try:
            outcomes.append(_outcome(sim, step, behave(sim, step, argument)))
        except ActionError as error:
            failure = error
        arguments_shown = ((ACTIONS[step.action].argument, argument_text(step)),)
        steps.append(Step(step.action, arguments_shown, began, sim.time_s))
        if failure is not None:
            break
    if failure is None:
        sim.wait(PAUSE_S)
    recording = replace(sim.recording(), steps=tuple(steps))
    held = sim.load.id if sim.load else None
    return Execution(recording, tuple(outcomes), failure, frozenset(sim.handled), held)


def reached(execution: Execution) -> bool:
    """Check that every step reached its goal and nothing else was moved."""
    return not execution.problems


def _outcome(sim: Simulation, step: ScriptStep, goal: Goal | None) -> Outcome:
    if goal is None:
        return Outcome(step, None)
    xyz, orientation = sim.body_pose(goal.thing)
    return Outcome(
        step,
        goal,
        float(np.linalg.norm(xyz - goal.xyz)),
        float(np.rad2deg(np.abs(wrap(heading(orientation) - goal.yaw)))),
        float(np.rad2deg(sim.lean(goal.thing))),
    )
