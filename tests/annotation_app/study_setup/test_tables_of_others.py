"""Videos, commands and things as other people's programs name them, and what isn't used of them."""

from __future__ import annotations

import json
import shutil
import unicodedata
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import func, select, text

from annotation_app.store.database import transaction
from annotation_app.store.models import Answer, Item, Slot, Study
from annotation_app.study_setup.coco_things import read_things
from annotation_app.study_setup.own_videos import OwnVideo, given_commands, own_videos
from annotation_app.study_setup.study_starting import read_parts
from corpus_tools.cli.console import run
from g3.errors import CorpusError, FormatError
from tests.annotation_app.browser import Browser, described, engine_of, row_in, rows_in
from tests.annotation_app.study_setup.clips import HEIGHT, WIDTH, clip
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.shared_cases import case

NFC, NFD = (unicodedata.normalize(form, "café") for form in ("NFC", "NFD"))


def study_of(folder: Path, **fields: Any) -> Path:
    study = {"name": "arm", "title": "An arm", "tasks": {"describe": {"practice": False}}}
    file = folder / "arm.yaml"
    file.write_text(json.dumps({**study, **fields}))
    return file


def copied(name: str, folder: Path) -> Path:
    """A copy of an input that may be written to."""
    made = folder / name
    for file in case(name).rglob("*"):
        if file.is_file():
            to = made / file.relative_to(case(name))
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, to)
    return made


def test_a_stray_mark_is_refused_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = copied("09-csv-quotes", tmp_path)
    for name, place in (("q1", "q1.csv:3:18"), ("q2", "q2.csv:2:18"), ("q3", "q3.csv:2:24")):
        call = ["annotate", "init", str(folder / "x.yaml"), "--videos", str(folder / f"{name}.csv")]
        assert run(call) == 2
        assert place in capsys.readouterr().err


def test_a_line_of_json_has_other_line_ends_in_it(tmp_path: Path) -> None:
    clip(tmp_path / "push.mp4")
    lines = ['{"video": "push.mp4", "command": "Push it.\u2028Stop.", "note": "a\x85b"}']
    (tmp_path / "t.jsonl").write_text("\n".join(lines), "utf-8")
    (video,) = own_videos(tmp_path / "t.jsonl")
    assert video.metadata == {"note": "a\x85b"}
    (command,) = given_commands(tmp_path / "t.jsonl", [video], has_videos=True)
    assert command.text == "Push it. Stop."
    folder = copied("10-jsonl-u2028", tmp_path)
    (video,) = own_videos(folder / "u2028.jsonl")
    (command,) = given_commands(folder / "u2028.jsonl", [video], has_videos=True)
    assert command.text == "Push the cup. Then stop."


def items(app: Any) -> Counter[str]:
    return Counter(rows_in(app, select(Item.video).where(Item.task == "describe")))


def test_a_file_is_asked_about_under_each_of_its_ids(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip(tmp_path / "push.mp4")
    shutil.copyfile(tmp_path / "push.mp4", tmp_path / "same.mp4")
    rows = ["video,id,condition", "push.mp4,a,fast", "push.mp4,b,slow", "same.mp4,c,fast"]
    (tmp_path / "t.csv").write_text("\n".join(rows))
    call = ["annotate", "init", str(tmp_path / "x.yaml"), "--videos", str(tmp_path / "t.csv")]
    assert run(call) == 0
    assert "for 3 videos" in capsys.readouterr().out
    with set_up(study_of(tmp_path, videos="t.csv")) as app:
        assert items(app) == {"a": 1, "b": 1, "c": 1}
        worker = Browser(app, study="arm")
        for _ in range(3):  # the same person, as in a test and a retest
            page = worker.lease("describe", "arm").json
            assert worker.answer(page["item"], described()).status_code == 200
        assert len(set(rows_in(app, select(Answer.subject)))) == 3
    with set_up(study_of(tmp_path, videos="t.csv")) as app:
        assert items(app) == {"a": 1, "b": 1, "c": 1}


def test_a_command_is_not_shown_with_the_same_film_as_another_one(tmp_path: Path) -> None:
    clip(tmp_path / "push.mp4")
    clip(tmp_path / "lift.mp4", 200)
    (tmp_path / "t.csv").write_text("video,id\npush.mp4,a\npush.mp4,b\nlift.mp4,c\n")
    (tmp_path / "c.csv").write_text("video,command\na,Go.\na,Stop.\na,Wait.\nb,Turn.\nb,Lift.\n")
    study = study_of(tmp_path, videos="t.csv", commands="c.csv", tasks={"rate": {}, "segment": {}})
    with set_up(study) as app:
        rated = rows_in(app, select(Item).where(Item.task == "rate"))
        assert len(rated) == 10
        for item in rated:
            assert item.payload["video"] in (item.payload["own_video"], "c")


def test_the_given_ids_of_one_file(tmp_path: Path) -> None:
    folder = copied("11-same-file-two-ids", tmp_path)
    with set_up(study_of(folder, videos="t.csv")) as app:
        assert items(app) == {"a": 1, "b": 1}


def test_a_replaced_file_makes_no_second_item(tmp_path: Path) -> None:
    clip(tmp_path / "clips/push.mp4", 40)
    file = study_of(tmp_path, videos="clips")
    with set_up(file) as app:
        before = row_in(app, select(Item.subject))
    clip(tmp_path / "clips/push.mp4", 90)
    with set_up(file) as app:
        assert items(app) == {"push": 1}
        assert row_in(app, select(func.count(Slot.id))) == 1
        assert row_in(app, select(Item.subject)) == before


def test_an_older_study_keeps_its_items_and_answers(tmp_path: Path) -> None:
    """Before, items were told apart by files: the second of equal ones was never asked about."""
    clip(tmp_path / "clips/push.mp4")
    shutil.copyfile(tmp_path / "clips/push.mp4", tmp_path / "clips/same.mp4")
    file = study_of(tmp_path, videos="clips")
    with set_up(file) as app:
        worker = Browser(app, study="arm")
        page = worker.lease("describe", "arm").json
        assert worker.answer(page["item"], described()).status_code == 200
        with transaction(engine_of(app)) as session:
            answered = session.scalars(select(Answer)).one()
            kept = session.get(Item, answered.item_id)
            assert kept is not None
            video, new = kept.video, kept.subject
            session.execute(text("DELETE FROM slot WHERE item_id != :i"), {"i": kept.id})
            session.execute(text("DELETE FROM handout WHERE item_id != :i"), {"i": kept.id})
            session.execute(text("DELETE FROM item WHERE id != :i"), {"i": kept.id})
            session.execute(text("UPDATE item SET subject = substr(subject, 1, 70)"))
            session.execute(text("UPDATE answer SET subject = substr(subject, 1, 70)"))
            session.execute(text("DROP TABLE assignment"))
            session.execute(text("UPDATE alembic_version SET version_num = '0012'"))
    for _ in range(2):
        with set_up(file) as app:
            assert items(app) == {"push": 1, "same": 1}
            assert rows_in(app, select(Answer.subject)) == [new]
            of_video = select(Item.subject).where(Item.video == video)
            assert rows_in(app, of_video) == [new]
    with set_up(file) as app:
        page = Browser(app, study="arm").lease("describe", "arm").json
        assert row_in(app, select(Item.video).where(Item.id == page["item"])) != video


def test_files_of_other_systems_are_not_looked_at(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip(tmp_path / "clips/push.mp4")
    for name in ("._push.mp4", ".hidden.mp4", ".DS_Store", "film.mov", "more/lift.mp4"):
        (tmp_path / "clips" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "clips" / name).write_bytes(b"\0")
    call = ["annotate", "init", str(tmp_path / "arm.yaml"), "--videos", str(tmp_path / "clips")]
    assert run(call) == 0
    told = capsys.readouterr()
    assert "for 1 video" in told.out
    assert "3 files are hidden, or another system's" in told.err
    assert "1 file is no mp4 or webm, and not used: film.mov" in told.err
    assert "1 file is in folders of this folder, and not used: more/lift.mp4" in told.err
    folder = copied("17-appledouble", tmp_path)
    notes: list[str] = []
    assert [item.video for item in own_videos(folder / "clips", notes.append)] == ["push"]
    assert "._push.mp4" in notes[0]


def test_rows_that_are_not_used_are_named(tmp_path: Path) -> None:
    clip(tmp_path / "push.mp4")
    rows = ["video,command,,", "push.mp4,Go.,,", "push.mp4,,,", ",,,", "push.mp4,Go.,,"]
    (tmp_path / "t.csv").write_text("\r\n".join([*rows, "._push.mp4,,,"]))
    notes: list[str] = []
    videos = own_videos(tmp_path / "t.csv", notes.append)
    assert len(videos) == 1
    assert "1 file is another system's and not looked at: line 6" in notes[0]
    assert "1 row is of a video that is in the table already" in notes[1]
    assert f"{tmp_path / 't.csv'}:3:1" in notes[1]
    notes.clear()
    assert len(given_commands(tmp_path / "t.csv", videos, notes.append)) == 1
    assert "2 rows are without a command: lines 3 and 6" in notes[0]
    assert "1 row is not used, as the same video has the same command already: line 5" in notes[1]


@pytest.mark.parametrize(("on_disk", "in_table"), [(NFD, NFC), (NFC, NFD)])
def test_names_with_accents_are_the_same_however_they_are_stored(
    tmp_path: Path, on_disk: str, in_table: str
) -> None:
    clip(tmp_path / f"clips/{on_disk}.mp4")
    (tmp_path / "c.csv").write_text(f"video,command\n{in_table},Go.\n", "utf-8")
    (tmp_path / "v.csv").write_text(f"video\nclips/{in_table}.mp4\n", "utf-8")
    (video,) = own_videos(tmp_path / "v.csv")
    assert video.file.name == f"{on_disk}.mp4"
    fields = {
        "videos": "clips",
        "commands": "c.csv",
        "only": [in_table],
        "pairs": [{"text": "Go.", "video": in_table, "own_video": in_table}],
        "tasks": {"describe": {}, "rate": {}},
    }
    with set_up(study_of(tmp_path, **fields)) as app:
        found = rows_in(app, select(Item.video))
        assert found
        assert set(found) == {on_disk}
    (tmp_path / f"clips/{on_disk}.mp4").rename(tmp_path / f"clips/{in_table}.mp4")
    with set_up(study_of(tmp_path, **fields)) as app:  # copied to another system
        assert rows_in(app, select(Item.video)) == found


def test_a_file_of_several_videos_names_none_of_them(tmp_path: Path) -> None:
    clip(tmp_path / "push.mp4")
    (tmp_path / "v.csv").write_text("video,id\npush.mp4,a\npush.mp4,b\n")
    (tmp_path / "c.csv").write_text("video,id,command\npush.mp4,b,Go.\npush.mp4,,Stop.\n")
    with pytest.raises(CorpusError) as caught:
        given_commands(tmp_path / "c.csv", own_videos(tmp_path / "v.csv"))
    assert caught.value.where == f"{tmp_path / 'c.csv'}:3:1: video"
    assert "the file of several videos: a, b" in caught.value.what


@pytest.mark.parametrize(
    ("content", "what"),
    [
        ("video,command\npush.mp4,Go.\n,Stop.\n", ":3:1: video: the row names no video"),
        (f"video\n{'x' * 100_000}\n", ":2:1: video: there is no file"),
        ("video,id,start_s,end_s\npush.mp4,a,1,x\n", ":2:12: start_s: '1' to 'x' is no part"),
    ],
)
def test_wrong_rows_are_refused(tmp_path: Path, content: str, what: str) -> None:
    clip(tmp_path / "push.mp4")
    (tmp_path / "t.csv").write_text(content)
    with pytest.raises(CorpusError, match=f"t.csv{what}") as caught:
        own_videos(tmp_path / "t.csv")
    assert len(str(caught.value)) < 1000


def test_other_tables_are_named_as_such(tmp_path: Path) -> None:
    (tmp_path / "t.tsv").write_text("video\tid\n")
    with pytest.raises(FormatError, match=r"a table of videos ends in \.csv or \.jsonl"):
        read_parts(study_of(tmp_path, videos="t.tsv"))


def coco(folder: Path, *names: str, **changes: Any) -> Path:
    """A COCO file with a thing in each of some images."""
    images = [
        {"id": n, "file_name": name, "width": WIDTH, "height": HEIGHT}
        for n, name in enumerate(names)
    ]
    things = [
        {"id": n, "image_id": n, "category_id": 1, "bbox": [1, 2, 3, 4]}
        for n, _ in enumerate(names)
    ]
    content = {"images": images, "annotations": things, "categories": [{"id": 1, "name": "cup"}]}
    file = folder / "things.json"
    file.write_text(json.dumps(content | changes), "utf-8-sig")
    return file


@pytest.mark.parametrize(
    "name",
    [
        "images\\push cup.jpg",
        "C:\\Users\\me\\frames\\push cup.png",
        "images/1/90fbb0c7-push_cup.jpg",
        "images\\1\\90fbb0c7-push_cup.jpg",
        "90fbb0c7-push%20cup.jpg",
        "/data/upload/1/90fbb0c7-push_cup.mp4",
        "/data/local-files/?d=clips%2Fpush%20cup.mp4",
        "/data/local-files/?d=clips\\push cup.mp4",
        "https://example.org/frames/push%20cup.jpg?token=7#top",
        "s3://bucket/frames/push cup.jpg",
        "push%20cup.jpg",
    ],
)
def test_an_image_is_matched_as_tools_name_it(tmp_path: Path, name: str) -> None:
    notes: list[str] = []
    videos = {"push cup": tmp_path / "push cup.mp4", "lift": tmp_path / "lift.mp4"}
    found = read_things(coco(tmp_path, name), videos, on_note=notes.append)
    assert set(found) == {"push cup"}
    exact = name.startswith("s3:")
    assert len(notes) == (0 if exact else 1)


def test_a_name_of_its_own_comes_first(tmp_path: Path) -> None:
    videos = {"90fbb0c7-push": tmp_path / "a.mp4", "push": tmp_path / "b.mp4"}
    notes: list[str] = []
    found = read_things(coco(tmp_path, "90fbb0c7-push.jpg"), videos, on_note=notes.append)
    assert (set(found), notes) == ({"90fbb0c7-push"}, [])


def test_an_image_of_several_videos_is_refused(tmp_path: Path) -> None:
    videos = {"push cup": tmp_path / "a.mp4", "push_cup": tmp_path / "b.mp4"}
    with pytest.raises(FormatError, match=r"image 0: its name .* of several videos: push cup, pu"):
        read_things(coco(tmp_path, "90fbb0c7-push_cup.jpg"), videos)
    same = {"a": tmp_path / "x/push.mp4", "b": tmp_path / "y/push.mp4"}
    with pytest.raises(FormatError, match="of several videos: a, b"):
        read_things(coco(tmp_path, "push.jpg"), same)
    parts = {"a": (0.0, 1.0), "b": (1.0, 2.0)}
    with pytest.raises(FormatError, match="of several videos: a, b"):
        read_things(coco(tmp_path, "push.jpg"), dict.fromkeys("ab", tmp_path / "push.mp4"), parts)


def test_an_image_is_of_each_video_that_shows_its_file(tmp_path: Path) -> None:
    found = read_things(coco(tmp_path, "push.jpg"), dict.fromkeys("ab", tmp_path / "push.mp4"))
    assert set(found) == {"a", "b"}


def test_images_without_a_video_are_counted_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip(tmp_path / "clips/push.mp4")
    coco(tmp_path, "push.jpg", "other.jpg", "third.jpg")
    file = study_of(tmp_path, videos="clips", things="things.json")
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "i")]) == 0
    told = capsys.readouterr().err
    assert "2 of 3 images, with 2 of 3 annotations, are of no video" in told
    assert "'other.jpg', 'third.jpg'" in told


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"categories": [{"id": 1, "name": "a"}, {"id": 1, "name": "b"}]}, "category 1: 2 times"),
        ({"images": [{"id": 0, "file_name": "p.jpg", "width": 9, "height": 9}] * 2}, "image 0: 2"),
    ],
)
def test_ids_that_are_given_twice_are_refused(
    tmp_path: Path, changes: dict[str, Any], what: str
) -> None:
    with pytest.raises(CorpusError, match=what):
        read_things(coco(tmp_path, "p.jpg", **changes), {"p": tmp_path / "p.mp4"})


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("[1, 2, 3, 4]", "[1, 2, NaN, 4]", "malformed"),
        ("[1, 2, 3, 4]", "[1, 2, 1e999, 4]", "out of range"),
        ('"id": 0, "file_name"', '"id": 0, "id": 0, "file_name"', "in the object already"),
        ('"file_name": "p.jpg"', '"file_name": 3', "expected `str`"),
    ],
)
def test_wrong_coco_is_refused_with_line_and_column(
    tmp_path: Path, old: str, new: str, what: str
) -> None:
    file = coco(tmp_path, "p.jpg")
    written = file.read_text("utf-8-sig")
    assert old in written
    file.write_text(written.replace(old, new))
    with pytest.raises(CorpusError, match=rf"things.json:1:\d+.*{what}"):
        read_things(file, {"p": tmp_path / "p.mp4"})


@pytest.mark.parametrize("name", ["win", "lsprefix"])
@pytest.mark.parametrize("tasks", ["", "-noground"])
def test_the_given_coco_files_are_matched(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, tasks: str
) -> None:
    folder = copied("13-coco-names", tmp_path)
    file = folder / f"st-{name}{tasks}.yaml"
    assert run(["annotate", "check", str(file), "--instance", str(tmp_path / "i")]) == 0
    assert "of push_cup" in capsys.readouterr().err
    (video,) = read_parts(file).videos
    assert isinstance(video, OwnVideo)
    assert video.things is not None


def test_a_study_that_is_there_keeps_its_names(tmp_path: Path) -> None:
    clip(tmp_path / f"clips/{NFD}.mp4")
    with set_up(study_of(tmp_path, videos="clips")) as app:
        assert row_in(app, select(Study.name)) == "arm"
        assert items(app) == {NFD: 1}
