"""What the artefact sets see, and that no default set sees the same."""

from __future__ import annotations

import numpy as np
import pytest

from g3.features.feature_registry import catalogue, select
from g3.groundings import FloatArray, Path, PhysicalObject
from g3.learning.examples import Example, to_batch
from tests.g3.features.scenes import one, row, table
from tests.worlds import line, log, robot, scene, thing

ARTEFACTS = {"start-pose", "scene-motion", "landmark-words", "robot-pose", "avs-log", "shape"}

OWN = log(line((0, 0), (10, 0)))
ELSEWHERE = log(line((3, 4), (13, 4)))
TRUCK = thing("truck", "trailer", 20, 50)


def event(path: Path, *objects: PhysicalObject) -> Example:
    return row(scene(*objects, TRUCK, agent=robot(OWN)), "EVENT", path, relation="go")


def test_they_are_off_unless_asked_for() -> None:
    assert not ARTEFACTS & {s.name for s in select()}
    assert {s.name for s in catalogue() if not s.default} == ARTEFACTS | {"word-tags"}
    assert {s.name for s in select(plus=["start-pose"])} >= {"start-pose"}


def test_a_displaced_path_shows_in_the_start_pose() -> None:
    assert one("start-pose", event(Path(OWN))) == {"away": 0, "turned": 0}
    assert one("start-pose", event(Path(ELSEWHERE))) == {"away": 5, "turned": 0}
    turned = log(OWN.xyz[:, :2], yaw=2 * np.pi - 0.5)
    assert one("start-pose", event(Path(turned)))["turned"] == pytest.approx(0.5)


def values_of(example: Example) -> dict[str, FloatArray]:
    batch = to_batch([example])
    return {
        f"{feature.name}/{column}": value
        for feature in select()
        for column, value in table(feature.name, batch).items()
    }


def test_a_displaced_path_shows_in_no_default_set() -> None:
    own, elsewhere = values_of(event(Path(OWN))), values_of(event(Path(ELSEWHERE)))
    assert own.keys() == elsewhere.keys()
    for name, value in own.items():
        np.testing.assert_allclose(elsewhere[name], value, atol=1e-9, err_msg=name)


def test_what_the_scene_carries() -> None:
    held = thing("load", "tire pallet", 1, 0, trajectory=log(OWN.xyz[:, :2] + [1, 0], z=0.5))
    assert one("scene-motion", event(Path(OWN), held)) == {"carries": 1, "carries_nothing": 0}
    far = Path(log(line((40, 40), (50, 40))))
    assert one("scene-motion", event(far, held)) == {"carries": 0, "carries_nothing": 1}
    assert one("scene-motion", event(Path(OWN))) == {"carries": 0, "carries_nothing": 1}


def test_where_the_robot_is() -> None:
    world = scene(TRUCK, agent=robot(OWN))
    assert one("robot-pose", row(world, "OBJECT", world.agent)) == {"away": 0}
    assert one("robot-pose", row(world, "OBJECT", robot(ELSEWHERE))) == {"away": 5}


def test_labels_of_landmarks_are_multiplied_with_their_own_words_only() -> None:
    (landmark_words,) = (s for s in catalogue() if s.name == "landmark-words")
    assert landmark_words.words == ("landmark",)
    assert not landmark_words.alone
    values = one("landmark-words", row(scene(TRUCK), "PATH", Path(OWN), landmark=(TRUCK,)))
    assert values == {"forklift": 0, "trailer": 1}
