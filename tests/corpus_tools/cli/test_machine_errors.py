"""Full disks, missing rights, interruptions: the file and the remedy are named."""

from __future__ import annotations

import errno
import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from corpus_tools.cli.console import run
from g3.storage import atomic_file
from g3.storage.system_errors import about, named_error
from tests.full_disks import full_disk, left_in
from tests.processes import python
from tests.tiny_corpus import tiny_corpus

PUT = "EVENT(r = Put, l = OBJ(f = the pallet))"
ROOMLESS = "No space left on device"


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    path = tmp_path_factory.mktemp("corpora") / "tiny"
    tiny_corpus().save(path)
    return str(path)


WRITERS = {
    "parse": (["parse", "Go to the truck", "--out", "{0}/out"], "out"),
    "graph": (["graph", PUT, "--format", "svg", "--out", "{0}/out.svg"], "out.svg"),
    "import": (["import", "authored", "warehouse-part", "--out", "{0}/out"], "out"),
    "export": (["corpus", "export", "{1}", "--to", "csv", "--out", "{0}/out"], "out"),
    "train": (["train", "g3", "--corpus", "{1}", "--out", "{0}/out"], "out.npz"),
    "learn": (["similarity", "learn", "{1}", "--out", "{0}/out.json"], "out.json"),
    "map": (["scenarios", "show", "dock_pick_up_tires", "--out", "{0}/out.svg"], "out.svg"),
    "generate": (["scenarios", "generate", "--seed", "1", "--count", "1", "--out", "{0}"], ""),
    "table": (["eval", "--table", "1", "--corpus", "{1}", "--cv", "scenario", "--out", "{0}/out"],
              "out"),
    "errors": (["eval", "--errors", "--corpus", "{1}", "--cv", "scenario", "--out", "{0}/out"],
               "out"),
    "shards": (["shards", "{1}", "--out", "{0}/out"], "out"),
    "init": (["annotate", "init", "{0}/out.yaml"], "out.yaml"),
    "serve": (["annotate", "serve", "--instance", "{0}/out", "--port", "0"], "out"),
    "people": (["annotate", "people", "invite", "--role", "admin", "--instance", "{0}/out"], "out"),
}  # fmt: skip


@pytest.mark.parametrize("name", [n for n in WRITERS if n != "import"])
def test_each_command_that_writes_names_the_file_on_a_full_disk(name, corpus, tmp_path, capsys):
    arguments, wanted = WRITERS[name]
    with full_disk(tmp_path / "disk") as disk:
        status = run([part.format(disk, corpus) for part in arguments])
        told = capsys.readouterr().err
        assert status == 2, told
        assert told.count("\n") == 1
        assert f"{disk / wanted}" in told
        assert ROOMLESS in told
        assert "make room" in told
        assert left_in(disk) == []


def test_an_import_names_the_file_on_a_full_disk(tmp_path, capsys):
    source = Path(__file__).parents[2] / "data/slu_core_small"
    with full_disk(tmp_path / "disk") as disk:
        assert run(["import", "slu-core", str(source), "--keep-going", "--out", f"{disk}/c"]) == 2
        told = capsys.readouterr().err
        assert f"ct: error: {disk}/c/" in told
        assert ROOMLESS in told
        assert left_in(disk) == []


def test_what_was_there_stays_when_the_disk_is_full(corpus, tmp_path, capsys):
    with full_disk(tmp_path / "disk", free_bytes=8192) as disk:
        (disk / "out.svg").write_text("old")
        assert run(["graph", PUT, "--out", f"{disk}/out.svg"]) == 0
        (disk / "out.svg").write_text("old")
        os.truncate(disk / "filler", 65536 - 4096)
        big = "; ".join(["OBJ(f = the pallet)"] * 200)
        assert run(["graph", big, "--format", "svg", "--out", f"{disk}/out.svg"]) == 2
        assert f"{disk}/out.svg: {ROOMLESS}" in capsys.readouterr().err
        assert (disk / "out.svg").read_text() == "old"
        assert left_in(disk) == ["out.svg"]


def test_a_limit_of_the_size_of_files(corpus, tmp_path):
    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))

    command = [sys.executable, "-m", "corpus_tools", "corpus", "export", corpus, "--to", "csv"]
    done = subprocess.run(
        [*command, "--out", str(tmp_path / "out")],
        preexec_fn=limit, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert f"ct: error: {tmp_path}/out/" in done.stderr
    assert "File too large" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_output_that_cannot_be_printed(corpus):
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    command = [sys.executable, "-m", "corpus_tools", "corpus", "stats", corpus]
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(f"ct: error: the standard output: {ROOMLESS}")
    assert done.stderr.count("\n") == 1


def test_a_folder_that_is_not_there_is_refused_before_the_work(corpus, tmp_path, capsys):
    """By all commands alike, whether they write a file or a folder."""
    missing = tmp_path / "missing"
    for arguments, _ in WRITERS.values():
        if "--out" in arguments:
            assert run([part.format(missing / "b", corpus) for part in arguments]) == 2
            assert "there is no such folder" in capsys.readouterr().err
    assert not missing.exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_to(tmp_path, capsys):
    tmp_path.chmod(0o500)
    assert run(["graph", PUT, "--out", f"{tmp_path}/out"]) == 2
    assert f"{tmp_path}/out: Permission denied" in capsys.readouterr().err


@pytest.mark.parametrize(
    "number", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EIO, errno.EMFILE]
)
def test_every_error_of_a_write_names_the_file(number, tmp_path, monkeypatch, capsys):
    def fail(descriptor: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", fail)
    assert run(["graph", PUT, "--out", f"{tmp_path}/out"]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"ct: error: {tmp_path}/out: {os.strerror(number)} (")
    assert list(tmp_path.iterdir()) == []


def test_temporary_names_are_replaced_by_those_that_people_know(tmp_path):
    for inner, shown in (("", "out"), ("/a/b", "out/a/b")):
        with pytest.raises(OSError, match="out") as found, about("out", instead_of=".out.new"):
            raise OSError(errno.ENOSPC, ROOMLESS, f".out.new{inner}")
        assert found.value.filename == shown
        error = named_error(found.value)
        assert error is not None
        assert error.where == shown
    assert named_error(ConnectionRefusedError(errno.ECONNREFUSED, "Connection refused")) is None


def test_long_names_of_many_bytes_can_be_written(tmp_path):
    path = tmp_path / ("字" * 84)
    atomic_file.write_bytes(path, b"all")
    assert path.read_bytes() == b"all"


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
def test_an_interruption_names_what_is_not_finished(tmp_path):
    out = tmp_path / "videos"
    command = [sys.executable, "-m", "corpus_tools", "scenarios", "generate", "--seed", "1"]
    command += ["--count", "100000", "--out", str(out)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + 60
    while not (out.is_dir() and any(out.iterdir())) and time.monotonic() < end:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert f"ct: interrupted: {out}" in told
    assert "run the same command again" in told
    assert all(path.suffix == ".yaml" for path in out.iterdir())
    assert not [path for path in out.iterdir() if path.name.startswith(".")]


def special(folder: Path, kind: str) -> Path:
    """A file that isn't a regular one."""
    path = folder / kind
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(str(path))
    elif kind == "folder":
        path.mkdir()
    elif kind == "huge":
        path.touch()
        os.truncate(path, 1 << 40)
    else:
        path.symlink_to("/dev/zero")
    return path


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such files")
def test_files_that_are_no_regular_ones_are_refused_at_once(corpus, tmp_path):
    """By one process with little memory, to which each would be fatal."""
    commands = []
    for kind in ("pipe", "socket", "device", "folder", "huge"):
        path = special(tmp_path, kind)
        commands += [["log", "show", path], ["graph", "--file", path], ["parse", "--file", path]]
        commands += [["scenarios", "show", path], ["parse", "Go", "--model", path]]
        commands += [["follow", "Go", "--scenario", "dock_pick_up_tires", "--model", path]]
        commands += [["annotate", "verify", path], ["annotate", "check", path]]
        for item in Path(corpus).iterdir():
            folder = tmp_path / f"{kind} {item.name}"
            shutil.copytree(corpus, folder)
            (folder / item.name).unlink()
            (folder / item.name).symlink_to(path)
            commands.append(["corpus", "stats", folder])
    code = "import resource, sys; from corpus_tools.cli.console import run\n"
    code += "resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))\n"
    code += f"for command in {[[str(part) for part in c] for c in commands]!r}:\n"
    code += "    print(run(command), flush=True)\n"
    done = python("-c", code)
    statuses = [line for line in done.stdout.splitlines() if len(line) == 1]
    assert statuses == ["2"] * len(commands), done.stdout + done.stderr
    assert "unexpected" not in done.stderr
    assert "memory" not in done.stderr
