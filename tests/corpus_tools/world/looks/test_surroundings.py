"""The ground, and what is painted on it."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings

from corpus_tools.world.looks.markings import MARGIN_M, PAINT_M, barrier, markings, yard_of
from corpus_tools.world.looks.painting import add_names
from corpus_tools.world.looks.parts import join
from corpus_tools.world.looks.site_looks import SITES, add_surroundings
from g3.geometry.plane import rotate
from g3.groundings import Context, PhysicalObject, Place, Prism
from tests.strategies import contexts
from tests.worlds import prism, still


def robot(yaw: float = 0.0) -> PhysicalObject:
    pose = still(0, 0, yaw=yaw)
    return PhysicalObject("robot", ("forklift",), prism(0, 0, (2, 2), (0.0, 2.0), yaw), pose)


def world(*places: Place, yaw: float = 0.0) -> Context:
    return Context("world", (robot(yaw),), places, "robot")


RECEIVING = Place(Prism(np.array([(10.0, 0), (14, 0), (14, 4), (10, 4)]), 0.0, 1.0), "receiving")


def test_the_yard_holds_everything_with_a_margin() -> None:
    yard = yard_of(world(RECEIVING))
    assert yard.yaw == pytest.approx(0)
    assert yard.middle == pytest.approx([6.5, 1.5])  # x from -1 to 14, y from -1 to 4
    assert yard.half == pytest.approx([7.5 + MARGIN_M, 2.5 + MARGIN_M])


def test_the_yard_is_laid_out_as_objects_stand() -> None:
    yard = yard_of(world(yaw=0.3))
    assert yard.yaw == pytest.approx(0.3)
    assert yard.half == pytest.approx([1 + MARGIN_M] * 2)
    assert yard_of(world(yaw=0.3 + np.pi / 2)).yaw == pytest.approx(0.3)


def test_only_named_places_are_painted() -> None:
    unnamed = replace(RECEIVING, name="")
    lines = {
        name: join(markings(world(place), yard_of(world(place)), 0.0)).at
        for name, place in (("named", RECEIVING), ("unnamed", unnamed))
    }

    def within(at: np.ndarray) -> np.ndarray:
        return at[((at[:, :2] >= (9.99, -0.01)) & (at[:, :2] <= (14.01, 4.01))).all(axis=1)]

    assert len(within(lines["unnamed"])) == 0
    zone = within(lines["named"])
    assert zone.min(axis=0) == pytest.approx([10, 0, PAINT_M])
    assert zone.max(axis=0) == pytest.approx([14, 4, PAINT_M])
    assert len(lines["named"]) == len(lines["unnamed"]) + len(zone)


def test_names_are_not_written() -> None:
    other = replace(RECEIVING, name="storage")
    painted = [
        join(markings(world(place), yard_of(world(place)), 0.0)) for place in (RECEIVING, other)
    ]
    assert (painted[0].at == painted[1].at).all()
    assert (painted[0].uv == painted[1].uv).all()


@settings(max_examples=10)
@given(contexts())
def test_the_edge_of_the_yard_is_away_from_everything(context: Context) -> None:
    yard = yard_of(context)
    walls = join(barrier(yard, 0.0)).at
    walls = rotate(walls[:, :2] - yard.middle, np.full(len(walls), -yard.yaw))
    assert (np.abs(walls) > yard.half - 1).any(axis=1).all()
    for item in context.objects:
        for xy in (item.prism.xy, item.trajectory.xyz[:, :2]):
            inside = rotate(xy - yard.middle, np.full(len(xy), -yard.yaw))
            assert (np.abs(inside) <= yard.half - MARGIN_M + 1e-6).all()


def test_the_sun_throws_shadows_and_the_ground_throws_none() -> None:
    spec = mujoco.MjSpec()
    add_surroundings(spec, world(RECEIVING), 0.25)
    model = spec.compile()
    assert model.nlight == 1
    assert model.light_castshadow[0]
    planes = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
    assert model.geom_pos[planes, 2].max() == pytest.approx(0.25)
    assert [geom.castshadow for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE] == [
        False
    ] * planes.sum()


@pytest.mark.parametrize("site", SITES)
def test_walls_are_at_the_edge_and_face_inwards(site: str) -> None:
    context = world(RECEIVING, yaw=0.4)
    yard = yard_of(context)
    surface = join(SITES[site].walls(context, yard, 0.25))
    assert surface.at[:, 2].min() == pytest.approx(0.25)
    flat = rotate(surface.at[:, :2] - yard.middle, np.full(len(surface.at), -yard.yaw))
    # Inside is free of anything up to the height of the forklift.
    low = surface.at[:, 2] < 0.25 + 3
    assert (np.abs(flat[low]) > yard.half - 1).any(axis=1).all()
    if site == "hall":
        outward = (surface.normal[:, :2] * (surface.at[:, :2] - yard.middle)).sum(axis=1)
        assert (outward <= 1e-9).all()
        assert (surface.normal[:, 2] <= 1e-9).all(), "the roof is seen from below only"


def test_a_warehouse_is_where_the_robot_looks_to() -> None:
    context = world(RECEIVING, yaw=0.4)
    surface = join(SITES["depot"].walls(context, yard_of(context), 0.0))
    front = surface.at[surface.at[:, 2] > 2] - context.agent.trajectory.xyz[0]
    assert (front[:, :2] @ (np.cos(0.4), np.sin(0.4)) > 5).all()


def test_grass_grows_outdoors_only() -> None:
    for site in SITES:
        spec = mujoco.MjSpec()
        add_surroundings(spec, world(RECEIVING), 0.0, site)
        assert (spec.material("grass") is not None) == (site != "hall")


def test_names_are_painted_where_they_are_asked_for() -> None:
    spec = mujoco.MjSpec()
    add_names(spec, world(RECEIVING, replace(RECEIVING, name="")), 0.0)
    model = spec.compile()
    assert model.ngeom == 1
    # The robot looks along x: the name is before the area, which begins at 10 and is at y 2.
    assert model.geom_pos[0, 0] < 10
    assert model.geom_pos[0, 1] == pytest.approx(2)
    letters = model.tex_data.reshape(-1, 3).astype(int).sum(axis=1)
    assert 0.05 < (letters < 200).mean() < 0.5
