"""The semantic maps that scenarios stand for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from corpus_tools.world.scenarios.boxes import Box, place_box, robot_box, thing_box
from corpus_tools.world.scenarios.scenario import ROBOT, Layout, Scenario
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS
from g3.geometry.plane import rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Place, Prism, Trajectory


def scenario_context(scenario: Scenario) -> Context:
    """Return the world at a scenario's start, in the frame of its layout's map.

    Objects have one pose, at time 0; it is at half their height, the robot's on the
    ground. The robot comes last.
    """
    layout, objects = scenario.layout, scenario.all_objects
    things = [
        replace(
            _physical(
                name, KINDS[thing.kind].labels, thing_box(thing, objects, scenario.robot), layout
            ),
            liftable=thing.liftable,
            colours=thing.colours,
        )
        for name, thing in objects.items()
    ]
    robot = _physical(ROBOT, FORKLIFT.labels, robot_box(scenario.robot), layout)
    places = scenario_places(scenario)
    return Context(scenario.id, (*things, robot), tuple(places.values()), ROBOT)


def scenario_places(scenario: Scenario) -> dict[str, Place]:
    """Return the places by id, in the order in which they are in the context."""
    objects = scenario.all_objects
    return {
        name: Place(_prism(place_box(region, objects), scenario.layout), region.name)
        for name, region in scenario.all_places.items()
    }


def in_map(points: FloatArray, layout: Layout) -> FloatArray:
    """Return points (..., 2) of a layout's frame in its map."""
    turned = rotate(points, np.full(points.shape[:-1], np.deg2rad(layout.yaw_deg)))
    moved: FloatArray = turned + np.array(layout.at)
    return moved


def _physical(name: str, labels: tuple[str, ...], box: Box, layout: Layout) -> PhysicalObject:
    x, y = in_map(box.pose[:2], layout)
    z = box.z_min if name == ROBOT else (box.z_min + box.z_max) / 2
    yaw = np.deg2rad(layout.yaw_deg) + box.pose[2]
    pose = Trajectory(np.zeros(1), np.array([[x, y, z]]), np.array([yaw]))
    return PhysicalObject(name, labels, _prism(box, layout), pose)


def _prism(box: Box, layout: Layout) -> Prism:
    return Prism(in_map(box.footprint, layout), box.z_min, box.z_max)
