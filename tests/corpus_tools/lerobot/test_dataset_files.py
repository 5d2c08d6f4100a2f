"""Names of files in other people's metadata stay in the dataset, and are filled in by name."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

from corpus_tools.cli.console import run
from corpus_tools.lerobot.dataset_files import files_below, filled_in
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from corpus_tools.lerobot.study_input import study_input
from g3.errors import FormatError
from tests.lerobot_datasets import CAMERA, image_dataset, new_dataset

NAMES = {"chunk_index": 1234, "file_index": 7, "video_key": "observation.images/top.left"}


def change(folder: Path, **fields: object) -> Path:
    file = folder / "meta/info.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | fields))
    return folder


@pytest.mark.parametrize(
    ("pattern", "name"),
    [
        ("videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
         "videos/observation.images/top.left/chunk-1234/file-007.mp4"),
        ("{chunk_index}/{file_index:d}", "1234/7"),
        ("{file_index:012d}", "000000000007"),
        ("the-only-file.mp4", "the-only-file.mp4"),
    ],
)  # fmt: skip
def test_patterns_are_filled_in_by_name(pattern: str, name: str):
    assert filled_in(pattern, NAMES, where="info.json") == name


@pytest.mark.parametrize(
    "pattern",
    [
        "{chunk_index:9999999999d}", "{chunk_index:999d}", "{chunk_index.__class__}",
        "{chunk_index!r}", "{0}", "{}", "{{chunk_index}}", "{video_key:03d}", "{secret}",
        "{chunk_index:>9d}", "{chunk_index:{file_index}d}", "{chunk_index", "chunk_index}",
    ],
)  # fmt: skip
def test_other_patterns_are_refused(pattern: str, tmp_path: Path):
    with pytest.raises(FormatError, match=r"info\.json, video_path") as error:
        filled_in(pattern, NAMES, where="info.json, video_path")
    assert "chunk_index" in error.value.fix
    folder = change(new_dataset(tmp_path / "set"), video_path=pattern)
    with pytest.raises(FormatError, match="no pattern"):
        study_input(open_dataset(folder), tmp_path / "out")


@pytest.mark.parametrize("field", ["video_path", "data_path"])
@pytest.mark.parametrize(
    "name", ["/etc/passwd", "../other.mp4", "videos/../../other.mp4", "C:\\film.mp4", "a\0b"]
)
def test_names_that_lead_out_are_refused(name: str, field: str, tmp_path: Path):
    folder = change(new_dataset(tmp_path / "set"), **{field: name})
    with pytest.raises(FormatError, match="leads out of the dataset") as error:
        study_input(open_dataset(folder), tmp_path / "out")
    assert error.value.where.endswith(f"info.json, {field}")


def test_keys_of_videos_are_names_too(tmp_path: Path):
    """A feature that is called ``..`` leads nowhere else."""
    folder = new_dataset(tmp_path / "set")
    info = json.loads((folder / "meta/info.json").read_text())
    features = {"../../../x": info["features"][CAMERA]}
    change(folder, features=features, codebase_version="v2.1", data_path=None, video_path=None)
    (folder / "meta/episodes.jsonl").write_text('{"episode_index": 0, "length": 12}')
    with pytest.raises(FormatError, match="leads out"):
        list(open_dataset(folder).episodes())


@pytest.mark.parametrize("place", ["videos", "data", "meta"])
def test_links_out_of_the_dataset_are_refused(place: str, tmp_path: Path):
    names = {
        "videos": f"videos/{CAMERA}/chunk-000/file-000.mp4",
        "data": "data/chunk-000/file-000.parquet",
        "meta": "meta/tasks.parquet",
    }
    folder = new_dataset(tmp_path / "set")
    file = folder / names[place]
    outside = tmp_path / file.name
    file.rename(outside)
    file.symlink_to(outside)
    with pytest.raises(FormatError, match="leads out of the dataset"):
        study_input(open_dataset(folder), tmp_path / "out")


def test_a_copy_has_no_files_from_elsewhere(tmp_path: Path):
    """A copy is published: a link in the dataset must not put other files into it."""
    folder = new_dataset(tmp_path / "set")
    (tmp_path / "secret").write_text("key")
    (folder / "meta/notes.txt").symlink_to(tmp_path / "secret")
    said = {0: EpisodeLanguage((Language("subtask", 0.0, "reach"),))}
    with pytest.raises(FormatError, match=r"notes\.txt"):
        write_language(open_dataset(folder), tmp_path / "copy", said, attachments={})
    assert not (tmp_path / "copy").exists()


def test_the_cache_of_hugging_face_has_links(tmp_path: Path):
    """Its snapshots are links into ``blobs``, which are part of the dataset."""
    folder = new_dataset(tmp_path / "datasets--me--x/snapshots/abc")
    blobs = tmp_path / "datasets--me--x/blobs"
    blobs.mkdir()
    for number, file in enumerate(f for f in sorted(folder.rglob("*")) if f.is_file()):
        file.rename(blobs / str(number))
        file.symlink_to(blobs / str(number))
    call = ["import", "lerobot", str(folder), "--out", str(tmp_path / "out")]
    assert run(call) == 0
    video = tmp_path / f"out/films/videos/{CAMERA}/chunk-000/file-000.mp4"
    assert video.samefile(folder / f"videos/{CAMERA}/chunk-000/file-000.mp4")
    tasks = {"describe": {"answers": 1, "practice": False}}
    study = {"name": "s", "title": "S", "videos": "out/episodes.csv", "tasks": tasks}
    (tmp_path / "study.yaml").write_text(json.dumps(study))
    assert run(["annotate", "check", str(tmp_path / "study.yaml")]) == 0
    said = {0: EpisodeLanguage((Language("subtask", 0.0, "reach"),))}
    write_language(open_dataset(folder), tmp_path / "copy", said, attachments={})
    assert (tmp_path / "copy/meta/info.json").is_file()


def test_pictures_stay_in_the_dataset_too(tmp_path: Path):
    folder = image_dataset(tmp_path / "set", as_files=True)
    (tmp_path / "other.png").write_bytes(b"secret")
    first = folder / f"images/{CAMERA}/episode_000000/frame_000000.png"
    first.unlink()
    first.symlink_to(tmp_path / "other.png")
    with pytest.raises(FormatError, match="leads out"):
        study_input(open_dataset(folder), tmp_path / "out", scratch=tmp_path / "films")


def test_files_come_in_the_order_of_their_numbers(tmp_path: Path):
    for name in ("chunk-999/file-000", "chunk-1000/file-000", "chunk-999/file-1000",
                 "chunk-999/file-999", "chunk-999/._file-000"):  # fmt: skip
        file = tmp_path / f"data/{name}.parquet"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    found = [f.relative_to(tmp_path / "data").as_posix() for f in files_below(tmp_path, "data")]
    assert found == [
        "chunk-999/file-000.parquet", "chunk-999/file-999.parquet", "chunk-999/file-1000.parquet",
        "chunk-1000/file-000.parquet",
    ]  # fmt: skip


def test_the_command_names_the_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    folder = change(new_dataset(tmp_path / "set"), video_path="{chunk_index:9999999999d}")
    assert run(["import", "lerobot", str(folder), "--out", str(tmp_path / "out")]) == 2
    assert "info.json, video_path" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
