"""What every look must be: in its box, only to be seen, and always the same."""

from __future__ import annotations

import sys
import zlib
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corpus_tools.world.looks.drawing import VISUAL_GROUP
from corpus_tools.world.looks.look_registry import look, look_of, plain
from corpus_tools.world.looks.site_looks import add_surroundings
from corpus_tools.world.looks.vehicles import DRAWBAR_LENGTH
from corpus_tools.world.state.dimensions import CAB_TOP, HEEL_X, LOW
from corpus_tools.world.state.forklift_parts import FORKS, add_forklift
from corpus_tools.world.state.shapes import Shape, shape_of
from corpus_tools.world.state.thing_kinds import KINDS, kind_of
from g3.groundings import Context, FloatArray, PhysicalObject, Place, Prism
from tests import worlds
from tests.processes import python
from tests.strategies import contexts

TOLERANCE_M = 0.02
FROM_BOX = {
    "truck": (np.array([0.02, 0.15, 0.0]), np.array([0.06, 0.15, 0.0])),
    "trailer": (np.array([0.02, 0.0, 0.0]), np.array([DRAWBAR_LENGTH + 0.12, 0.0, 0.0])),
}
FROM_BOX |= dict.fromkeys(("flatbed-truck", "semi-truck"), FROM_BOX["truck"])
"""How far looks may reach out of their boxes, besides the tolerance: mirrors and lamps of a
truck, the drawbar of a trailer. Both reach down to the ground, a truck's cab to its top."""
THINGS = sorted(set(KINDS) - {"forklift"})


def dressed(kind: str, shape: Shape, ground_m: float, name: str = "thing") -> mujoco.MjModel:
    """A model of one thing that is only seen."""
    spec = mujoco.MjSpec()
    look_of(kind)(spec, spec.worldbody.add_body(name=name), shape, ground_m)
    return spec.compile()


def corners(model: mujoco.MjModel, body: str = "thing") -> FloatArray:
    """Corners of everything that is seen of a body, in its frame, shape (n, 3)."""
    found = []
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    root = model.body(body).id
    limbs = [i for i in range(model.nbody) if model.body(i).name.startswith(f"{body} ")]
    for geom in np.flatnonzero(np.isin(model.geom_bodyid, [root, *limbs])):
        assert model.geom_group[geom] == VISUAL_GROUP
        mesh = model.geom_dataid[geom]
        start, n = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        at = model.mesh_vert[start : start + n] @ data.geom_xmat[geom].reshape(3, 3).T
        at += data.geom_xpos[geom] - data.xpos[root]
        found.append(at @ data.xmat[root].reshape(3, 3))
    return np.concatenate(found)


def typical(kind: str) -> tuple[Shape, float]:
    """A box as large as usual, its frame in its middle as in the paper's corpus, and the ground."""
    known = KINDS[kind]
    half = np.array([*known.size, known.heights[1] - known.heights[0]]) / 2
    return Shape(-half, half), -half[2] - known.heights[0]


def test_every_kind_has_a_look() -> None:
    assert [kind for kind in KINDS if look_of(kind) is plain] == []
    assert look_of("something else") is plain


def test_a_kind_has_one_look() -> None:
    with pytest.raises(ValueError, match="'truck' is registered already"):
        look("truck")(plain)


@pytest.mark.parametrize("kind", [*THINGS, "something else"])
@pytest.mark.parametrize("factor", [0.8, 1.0, 1.1])
def test_looks_fill_their_boxes(kind: str, factor: float) -> None:
    shape, ground_m = typical(kind if kind in KINDS else "other")
    shape = Shape(factor * shape.low, factor * shape.high)
    seen = corners(dressed(kind, shape, ground_m))
    below, above = FROM_BOX.get(kind, (np.zeros(3), np.zeros(3)))
    low, high = shape.low - below - TOLERANCE_M, shape.high + above + TOLERANCE_M
    if kind in FROM_BOX:
        low[2] = ground_m - TOLERANCE_M
    if kind.endswith("truck"):
        high[2] = ground_m + CAB_TOP + 0.06  # lamps on the cab
    assert (seen >= low).all()
    assert (seen <= high).all()
    narrow = 0.1 * shape.size
    narrow[0] = np.inf if kind == "person" else narrow[0]  # people are wider than deep
    assert (seen.min(axis=0) <= shape.low + narrow).all()
    assert (seen.max(axis=0) >= shape.high - narrow).all()


@pytest.mark.parametrize("kind", ["truck", "trailer"])
def test_wheels_stand_on_the_ground(kind: str) -> None:
    shape, ground_m = typical(kind)
    assert corners(dressed(kind, shape, ground_m))[:, 2].min() == pytest.approx(ground_m, abs=1e-3)


@pytest.mark.parametrize("kind", THINGS)
@pytest.mark.parametrize("flat", [0, 1, 2])
def test_flat_boxes_have_looks_too(kind: str, flat: int) -> None:
    shape, ground_m = typical(kind)
    high = shape.high.copy()
    high[flat] = shape.low[flat]
    assert dressed(kind, Shape(shape.low, high), ground_m).ngeom >= 1


def test_the_forklift_is_where_its_body_is() -> None:
    spec = mujoco.MjSpec()
    body = add_forklift(spec, "robot")
    look_of("forklift")(spec, body, typical("forklift")[0], 0.0)
    for solid in [geom for geom in spec.geoms if geom.group != VISUAL_GROUP]:
        spec.delete(solid)
    model = spec_without_weight(spec)
    chassis, forks = corners(model, "robot"), corners(model, FORKS)
    assert chassis.min(axis=0) == pytest.approx([-1.2, -0.56, 0.0], abs=0.04)
    assert chassis.max(axis=0) == pytest.approx([HEEL_X - 0.05, 0.56, 2.1], abs=0.04)
    in_front = forks[forks[:, 0] > 0.01]
    assert in_front[:, 2].max() == pytest.approx(0, abs=1e-6), "loads stand on the tines"
    assert in_front[:, 2].min() == pytest.approx(-0.04, abs=1e-6)
    assert forks[:, 2].min() > -LOW


def spec_without_weight(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model of a spec whose moving bodies have no geom that weighs anything."""
    for body in spec.bodies[1:]:
        body.mass, body.inertia, body.explicitinertial = 1.0, [1.0, 1.0, 1.0], True
    return spec.compile()


def thing(kind: str, name: str, x: float) -> PhysicalObject:
    known = KINDS[kind]
    return worlds.thing(
        name, " ".join(known.labels), x, 0.0, known.size, known.heights, worlds.still(x, 0)
    )


def square(x: float, name: str) -> Place:
    return Place(Prism(np.array([(x, 8), (x + 4, 8), (x + 4, 12), (x, 12)]), 0.0, 1.0), name)


EVERYTHING = Context(
    "everything",
    tuple(thing(kind, kind, 8.0 * i) for i, kind in enumerate(KINDS)),
    (square(0.0, "receiving"), square(9.0, "")),
    "forklift",
)


def scene(context: Context) -> mujoco.MjSpec:
    """What is seen of a context, without what collides."""
    spec = mujoco.MjSpec()
    for i, item in enumerate(context.objects):
        body = spec.worldbody.add_body(name=f"thing {i}", pos=item.trajectory.xyz[0])
        if item.id == context.agent_id:
            body.add_body(name=FORKS)
            look_of("forklift")(spec, body, shape_of(item), 0.0)
        else:
            look_of(kind_of(item.labels).name)(spec, body, shape_of(item), -body.pos[2])
    add_surroundings(spec, context, 0.0)
    return spec


def test_looks_are_only_there_to_be_seen() -> None:
    model = scene(EVERYTHING).compile()
    assert model.ngeom > len(KINDS)
    assert (model.geom_group == VISUAL_GROUP).all()
    assert (model.geom_contype == 0).all()
    assert (model.geom_conaffinity == 0).all()
    assert (model.body_mass[model.body_jntnum == 0] == 0).all()


def test_a_thing_is_one_or_two_geoms_of_few_triangles() -> None:
    model = scene(EVERYTHING).compile()
    assert np.bincount(model.geom_bodyid)[1:].max() <= 2
    assert model.mesh_facenum.max() < 2500


def test_things_differ_by_name_and_equal_ones_share_their_mesh() -> None:
    def meshes(kind: str, *names: str) -> int:
        spec = mujoco.MjSpec()
        for name in names:
            look_of(kind)(spec, spec.worldbody.add_body(name=name), *typical(kind))
        return len(spec.meshes)

    assert meshes("box-pallet", "one", "two", "three") == 3
    assert meshes("truck", "truck-1", "truck-3") == 2, "the truck and its cab"
    assert meshes("truck", "truck-1", "truck-2") == 4, "of two liveries"


def saved(model: mujoco.MjModel) -> bytes:
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def test_a_context_always_looks_the_same() -> None:
    assert saved(scene(EVERYTHING).compile()) == saved(scene(EVERYTHING).compile())


def test_looks_do_not_depend_on_the_process() -> None:
    program = (
        "import sys, zlib; sys.path[:0] = sys.argv[1:]\n"
        "from test_looks import EVERYTHING, saved, scene\n"
        "print(zlib.crc32(saved(scene(EVERYTHING).compile())))"
    )
    folders = [str(Path(__file__).parent), *(path for path in sys.path if path)]
    other = python("-c", program, *folders, PYTHONHASHSEED="1")
    assert int(other.stdout) == zlib.crc32(saved(scene(EVERYTHING).compile()))


@settings(max_examples=8)
@given(contexts(), st.sampled_from(THINGS))
def test_any_context_can_be_seen(context: Context, kind: str) -> None:
    model = scene(context).compile()
    assert np.isfinite(model.mesh_vert).all()
    item = context.objects[0]
    assert dressed(kind, shape_of(item), -item.trajectory.xyz[0, 2]).ngeom >= 1


@pytest.mark.parametrize(
    ("labels", "kind"),
    [
        (("tire", "assembly", "pallet"), "tire-pallet"),
        (("flatbed", "trailer"), "trailer"),
        (("flatbed truck",), "flatbed-truck"),
        (("semi", "truck"), "semi-truck"),
        (("truck",), "truck"),
        (("refrigerator", "pallet"), "refrigerator-pallet"),
        (("washing machine pallet",), "washing-machine-pallet"),
        (("generator", "pallet"), "generator-pallet"),
        (("generator", "accessories", "pallet"), "generator-accessories-pallet"),
        (("Bricks", "pallet"), "bricks-pallet"),
        (("ship_container",), "container"),
        (("sign", "post"), "sign"),
        (("berm",), "berm"),
        (("operator",), "person"),
        (("drum of 55 gallons",), "barrel"),
        (("spaceship",), "other"),
    ],
)
def test_labels_of_other_corpora_are_understood(labels: tuple[str, ...], kind: str) -> None:
    assert kind_of(labels).name == kind
