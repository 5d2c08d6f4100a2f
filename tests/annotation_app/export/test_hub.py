"""Datasets are fetched from a hub and pushed to it once, only when it is asked for by name."""

from __future__ import annotations

import csv
import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("huggingface_hub", reason="the extra `hub` is not installed")

from tests.annotation_app.browser import Browser, described
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import study_of
from tests.hub_server import TOKEN, Hub, Repository, running_hub
from tests.lerobot_datasets import new_dataset
from tests.processes import ct

NAME = "lab/with-language"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of a dataset, with a description of each episode."""
    folder = tmp_path_factory.mktemp("study")
    with set_up(study_of(folder)) as app:
        worker = Browser(app, study="robot")
        for _ in range(3):
            page = worker.lease("describe", "robot").json
            assert worker.answer(page["item"], described("Do it.")).status_code == 200
    return folder


@pytest.fixture
def hub() -> Iterator[Hub]:
    with running_hub() as server:
        yield server


def called(
    hub: Hub, folder: Path, *call: object, token: str = TOKEN
) -> subprocess.CompletedProcess[str]:
    done = ct(
        *call, HF_ENDPOINT=hub.url, HF_HOME=str(folder / "hf"), HF_TOKEN=token,
        HF_HUB_DISABLE_XET="1", HF_HUB_DISABLE_PROGRESS_BARS="1",
    )  # fmt: skip
    assert TOKEN not in done.stdout + done.stderr
    return done


def pushed(
    hub: Hub, study: Path, out: Path, *more: str, token: str = TOKEN
) -> subprocess.CompletedProcess[str]:
    call = ["annotate", "export", out, "--format", "lerobot", "--push-to", NAME, "--force"]
    return called(hub, out.parent, *call, "--instance", study / "instance", *more, token=token)


def content(folder: Path) -> dict[str, bytes]:
    files = (f for f in folder.rglob("*") if f.is_file())
    return {f.relative_to(folder).as_posix(): f.read_bytes() for f in files}


def test_a_copy_is_pushed_once(study: Path, tmp_path: Path, hub: Hub):
    done = pushed(hub, study, tmp_path / "copy", "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)["pushed"]
    repository = hub.repositories[NAME]
    assert (told["repo_id"], told["commit"], told["is_new"]) == (NAME, repository.head, True)
    assert repository.is_private
    assert {k: v for k, v in repository.files.items() if k != ".gitattributes"} == content(
        tmp_path / "copy"
    )
    assert repository.tags == {"v3.0": repository.head}
    assert len(repository.commits) == 2
    assert len(hub.sent) == 2  # the videos of two cameras
    again = pushed(hub, study, tmp_path / "copy", "--json")
    assert json.loads(again.stdout)["pushed"] == told | {"is_new": False}
    assert (len(repository.commits), len(hub.sent)) == (2, 2)
    for file in study.rglob("*"):
        assert not file.is_file() or TOKEN.encode() not in file.read_bytes()


def test_an_answer_that_is_lost(study: Path, tmp_path: Path, hub: Hub):
    hub.loses_next_answer = True
    done = pushed(hub, study, tmp_path / "copy")
    assert done.returncode == 2
    assert "it isn't made again" in done.stderr
    repository = hub.repositories[NAME]
    assert (len(repository.commits), repository.tags) == (2, {})
    done = pushed(hub, study, tmp_path / "copy")
    assert (done.returncode, len(repository.commits)) == (0, 2)
    assert "has all of this already" in done.stdout
    assert repository.tags == {"v3.0": repository.head}


def test_what_others_have_written_stays(study: Path, tmp_path: Path, hub: Hub):
    assert pushed(hub, study, tmp_path / "copy").returncode == 0
    repository = hub.repositories[NAME]
    old = {"videos/gone.mp4": b"x", "README.md": b"Mine.", "meta/info.json": b"{}"}
    repository.commits.append(old)

    def quicker() -> None:
        repository.commits.append(old | {"data/theirs": b"x"})

    hub.before_commit = quicker
    done = pushed(hub, study, tmp_path / "copy")
    assert done.returncode == 2
    assert "somebody has changed the dataset" in done.stderr
    assert "data/theirs" in repository.files
    assert pushed(hub, study, tmp_path / "copy").returncode == 0
    expected = content(tmp_path / "copy") | {"README.md": b"Mine."}
    assert repository.files == expected
    assert repository.tags == {"v3.0": repository.head}


def test_what_is_refused(study: Path, tmp_path: Path, hub: Hub):
    done = pushed(hub, study, tmp_path / "copy", token="")
    assert done.returncode == 2
    assert "nobody is logged in" in done.stderr
    assert not (tmp_path / "copy").exists()
    done = pushed(hub, study, tmp_path / "copy", token="hf_wrong")
    assert (done.returncode, "401" in done.stderr) == (2, True)
    hub.repositories[NAME] = Repository([{"train.csv": b"x"}])
    done = pushed(hub, study, tmp_path / "copy")
    assert done.returncode == 2
    assert "something else under this name" in done.stderr
    assert hub.repositories[NAME].files == {"train.csv": b"x"}
    call = ["annotate", "export", tmp_path / "x", "--instance", study / "instance", "--push-to"]
    done = called(hub, tmp_path, *call, NAME)
    assert (done.returncode, "only lerobot takes push-to" in done.stderr) == (2, True)
    done = called(hub, tmp_path, *call, "no/such/name", "--format", "lerobot")
    assert (done.returncode, "no name of a dataset" in done.stderr) == (2, True)


def test_a_dataset_is_fetched(tmp_path: Path, hub: Hub):
    source = new_dataset(tmp_path / "set")
    hub.repositories["lab/set"] = Repository([content(source)])
    call = ["import", "lerobot", "--repo-id", "lab/set", "--out", tmp_path / "tables"]
    done = called(hub, tmp_path, *call)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "tables/episodes.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3
    folder = Path(rows[0]["dataset"])
    assert folder.name == hub.repositories["lab/set"].head
    assert os.path.commonpath([folder, tmp_path / "hf"]) == str(tmp_path / "hf")
    assert (tmp_path / "tables" / rows[0]["video"]).exists()


def test_no_dataset_is_fetched(tmp_path: Path, hub: Hub):
    out = tmp_path / "tables"
    done = called(hub, tmp_path, "import", "lerobot", "--repo-id", "lab/none", "--out", out)
    assert done.returncode == 2
    assert "404" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    for call in (["--out", out], [tmp_path, "--repo-id", "lab/set", "--out", out]):
        done = called(hub, tmp_path, "import", "lerobot", *call)
        assert (done.returncode, "either a dataset's folder or --repo-id" in done.stderr) == (
            2,
            True,
        )
    hub.url = "http://127.0.0.1:9"
    done = called(hub, tmp_path, "import", "lerobot", "--repo-id", "lab/none", "--out", out)
    assert done.returncode == 2, done.stderr
    assert not out.exists()
