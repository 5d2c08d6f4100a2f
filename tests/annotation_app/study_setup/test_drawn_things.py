"""What people draw is kept as a COCO file, beside what such a file had before."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from annotation_app.study_setup.coco_things import read_things
from annotation_app.study_setup.drawn_things import (
    DrawnPicture,
    DrawnThing,
    Moment,
    drawn_things,
    names_in,
    write_drawn,
)
from g3.errors import FormatError
from tests.annotation_app.study_setup.clips import HEIGHT, WIDTH
from tests.annotation_app.study_setup.test_coco_things import COCO

VIDEOS = {"push": Path("push.mp4"), "lift": Path("lift.webm")}


def box(x: float, y: float, w: float, h: float) -> list[tuple[float, float]]:
    return [(x, y), (x + w, y), (x + w, y + h), (x, y + h)]


def cup(*moments: Moment, name: str = "cup", id_: str = "7") -> DrawnThing:
    return DrawnThing(id_, name, is_box=True, moments=list(moments))


def write(
    folder: Path, *things: DrawnThing, source: Path | None = None, video: str = "push"
) -> Any:
    """Write what is drawn in a video over what there is; give what is read again."""
    before = read_things(source, VIDEOS).get(video) if source else None
    size = (before.width, before.height) if before else (WIDTH, HEIGHT)
    target = folder / "drawn.json"
    write_drawn(source, target, VIDEOS, DrawnPicture(video, *size, things, before))
    return read_things(target, VIDEOS)


def test_boxes_and_outlines_come_back_as_they_were_drawn(tmp_path: Path) -> None:
    outline = [(1.5, 2.0), (30.0, 2.5), (20.0, 40.0)]
    drawn = (
        cup(Moment(0.0, [box(2, 3, 20, 30)])),
        DrawnThing("8", " ", is_box=False, moments=[Moment(0.0, [outline])]),
    )
    found = write(tmp_path, *drawn)["push"]
    assert found.picture is None
    assert [(one["id"], one["label"], one["box"]) for one in found.things] == [
        ("7", "cup", [2, 3, 20, 30]),
        ("8", "thing", [1.5, 2, 28.5, 38]),
    ]
    assert "moments" not in found.things[0]
    first, second = drawn_things(found)
    assert first == drawn[0]
    assert second.moments == drawn[1].moments
    assert names_in(tmp_path / "drawn.json") == ["cup"]


def test_a_thing_at_several_moments_is_one_thing(tmp_path: Path) -> None:
    late = cup(Moment(0.4, [box(5, 5, 9, 9)]), id_="x-1")
    moving = cup(
        Moment(0.0, [box(2, 3, 20, 30)]), Moment(0.5, [box(12, 3, 20, 30)], is_keyframe=False)
    )
    found = write(tmp_path, moving, late)["push"]
    by_id = {one.id: one for one in drawn_things(found)}
    assert by_id == {"7": moving, "x-1": late}
    assert found.things[0]["box"] == [2, 3, 20, 30]
    coco = json.loads((tmp_path / "drawn.json").read_text())
    assert [image["time_s"] for image in coco["images"]] == [0.0, 0.4, 0.5]
    write(tmp_path, late, source=tmp_path / "drawn.json")
    coco = json.loads((tmp_path / "drawn.json").read_text())
    assert [image["time_s"] for image in coco["images"]] == [0.4]


def test_what_others_have_marked_stays(tmp_path: Path) -> None:
    (tmp_path / "given/stills").mkdir(parents=True)
    given = tmp_path / "given/things.json"
    cv2.imwrite(str(given.parent / "stills/push.png"), np.zeros((100, 200, 3), np.uint8))
    marked = {**COCO, "info": {"year": 2026}}
    given.write_text(json.dumps(marked))
    before = read_things(given, VIDEOS)
    kept = drawn_things(before["push"])[0]
    found = write(tmp_path, kept, cup(Moment(0.0, [box(1, 1, 5, 5)]), id_="20"), source=given)
    assert found["lift"] == before["lift"]
    assert found["push"].picture == before["push"].picture
    assert found["push"].things[0] == before["push"].things[0]
    assert [one["id"] for one in found["push"].things] == ["17", "20"]
    coco = json.loads((tmp_path / "drawn.json").read_text())
    assert coco["info"] == {"year": 2026}
    assert coco["annotations"][0]["segmentation"] == COCO["annotations"][2]["segmentation"]
    with pytest.raises(FormatError, match="another thing has the id 19"):
        write(tmp_path, cup(Moment(0.0, [box(1, 1, 5, 5)]), id_="19"), source=given)


@pytest.mark.parametrize("wrong", [(60, 3, 20, 30), (2, 3, 0, 30), (-9, 3, 20, 30)])
def test_what_is_not_in_the_picture_is_refused(tmp_path: Path, wrong: tuple[float, ...]) -> None:
    with pytest.raises(FormatError, match="thing 1 isn't in the picture"):
        write(tmp_path, cup(Moment(0.0, [box(*wrong)])))
    assert not (tmp_path / "drawn.json").exists()
