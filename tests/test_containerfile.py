"""The image of the app: built where Docker or Podman runs, else its steps are taken one by one."""

from __future__ import annotations

import json
import shlex
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hatchling.builders.wheel import WheelBuilder

from tests.test_packaging import PACKAGES, ROOT

PORT = "8765"
PATIENCE_S = 60.0


def steps() -> list[tuple[str, str]]:
    """The instructions, with lines put together."""
    text = (ROOT / "Containerfile").read_text().replace("\\\n", " ")
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return [(word, rest) for word, _, rest in (line.partition(" ") for line in lines)]


def values(word: str) -> list[str]:
    return [rest for name, rest in steps() if name == word]


def copied() -> Iterator[tuple[str, str]]:
    """What is copied from the checkout, and where to in the folder of the wheel's sources."""
    for rest in values("COPY"):
        *sources, target = shlex.split(rest)
        if not sources[0].startswith("--from"):
            yield from ((source, target) for source in sources)


def test_what_is_copied_is_enough_for_the_wheel(tmp_path: Path) -> None:
    (tmp_path / "source").mkdir()
    for source, target in copied():
        there, to = ROOT / source, tmp_path / "source" / target
        if there.is_dir():
            shutil.copytree(there, to, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(there, to / source if target.endswith("/") else to)
    (path,) = WheelBuilder(str(tmp_path / "source")).build(directory=str(tmp_path / "wheel"))
    names = zipfile.ZipFile(path).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == set(PACKAGES)
    assert "corpus_tools/datasets/warehouse/dataset.yaml" in names


def test_it_is_run_by_nobody_special_and_keeps_its_folder() -> None:
    order = [word for word, _ in steps()]
    (user,) = values("USER")
    assert user == "g3"
    assert order.index("USER") < order.index("ENTRYPOINT")
    (volume,) = values("VOLUME")
    command = json.loads(values("ENTRYPOINT")[0])
    kept = [command[command.index(option) + 1] for option in ("--instance", "--studies")]
    assert all(Path(volume) in Path(folder).parents for folder in kept)
    assert values("EXPOSE") == [PORT]
    assert command[command.index("--port") + 1] == PORT


@pytest.mark.slow
def test_its_command_serves_and_its_check_sees_it(tmp_path: Path) -> None:
    """As in the image, but in another folder, at another port, and by this Python."""
    ct, *arguments = json.loads(values("ENTRYPOINT")[0]) + json.loads(values("CMD")[0])
    assert ct == "ct"
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = str(probe.getsockname()[1])
    arguments[arguments.index("--port") + 1] = port
    moved = [one.replace("/data/", f"{tmp_path}/") for one in arguments]
    with subprocess.Popen(
        [sys.executable, "-m", "corpus_tools", *moved],
        stdout=subprocess.PIPE,
        cwd=tmp_path,
        text=True,
    ) as server:
        try:
            assert server.stdout is not None
            told = ""
            while "Ctrl-C" not in told:
                line = server.stdout.readline()
                assert line, told
                told += line
            assert "make the first admin" in told
            assert checked(port) == 0
            assert checked("1") != 0
        finally:
            server.terminate()
            server.wait(PATIENCE_S)
    assert [path.name for path in tmp_path.iterdir()] == ["annotation"]  # studies come later


def checked(port: str) -> int:
    """What the image's health check says of a port."""
    (rest,) = values("HEALTHCHECK")
    python, *arguments = json.loads(rest[rest.index("[") :])
    assert python == "python"
    command = [one.replace(PORT, port) for one in arguments]
    done = subprocess.run([sys.executable, *command], capture_output=True, check=False)
    return done.returncode


def runtime() -> str | None:
    """A program that runs containers here."""
    for name in ("docker", "podman"):
        program = shutil.which(name)
        if program:
            done = subprocess.run([program, "info"], capture_output=True, check=False)
            if done.returncode == 0:
                return program
    return None


@pytest.mark.slow
def test_the_image_is_built_and_runs() -> None:
    program = runtime()
    if program is None:
        pytest.skip("no Docker and no Podman runs here")

    def call(*words: str) -> str:
        done = subprocess.run(
            [program, *words], check=True, capture_output=True, text=True, cwd=ROOT
        )
        return done.stdout.strip()

    call("build", "--file", "Containerfile", "--tag", "ct-tests", ".")
    container = call("run", "--detach", "--publish", f"127.0.0.1::{PORT}", "ct-tests")
    try:
        address = call("port", container, PORT).splitlines()[0]
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                with urllib.request.urlopen(f"http://{address}/login") as reply:
                    assert reply.status == 200
                break
            except OSError:
                assert time.monotonic() < end, call("logs", container)
                time.sleep(0.5)
        assert call("exec", container, "id", "-u") == "1000"
    finally:
        call("rm", "--force", container)
        call("image", "rm", "ct-tests")
