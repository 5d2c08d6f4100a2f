"""``ct doctor`` and ``ct completion``."""

from __future__ import annotations

import importlib.metadata
import json
import os
import shutil
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import pytest

from corpus_tools.cli.console import run
from corpus_tools.doctor.diagnosis import checks, diagnose
from g3.errors import CorpusError
from tests.processes import ct


@pytest.fixture
def doctor(capsys):
    """Runs checks and gives the status and what was found, by the check's name."""

    def doctor(*names):
        status = run(["doctor", *names, "--format", "json"])
        found = json.loads(capsys.readouterr().out)["checks"]
        return status, {finding["name"]: finding for finding in found}

    return doctor


def test_all_checks_pass_where_the_tests_run(doctor):
    status, found = doctor()
    assert [f for f in found.values() if not f["ok"]] == []
    assert status == 0
    assert {"corpora", "database", "disk", "drawing", "encoding", "parsing", "wordnet"} <= set(
        found
    )


def test_what_is_missing_is_told_with_its_remedy(doctor, monkeypatch, tmp_path):
    monkeypatch.setenv("CT_WORDNET", str(tmp_path))
    status, found = doctor("wordnet", "disk")
    assert status == 2
    assert found["disk"]["ok"]
    assert not found["wordnet"]["ok"]
    assert str(tmp_path) in found["wordnet"]["found"]
    assert "wordnet-base" in found["wordnet"]["fix"]


def test_a_table_for_people(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("CT_WORDNET", str(tmp_path))
    assert run(["doctor", "wordnet", "image-tags"]) == 2
    failed, *remedy, passed = capsys.readouterr().out.splitlines()
    assert failed.startswith("no  wordnet")
    assert "wordnet-base" in " ".join(remedy)
    assert passed.startswith("ok  image-tags")


def test_a_broken_check_does_not_stop_the_others():
    def missing():
        raise CorpusError("it is not there", where="/x", fix="get it")

    def broken():
        raise OSError("lib.so: no such file")

    found = list(diagnose({"missing": missing, "broken": broken, "fine": lambda: "all of it"}))
    assert [f.ok for f in found] == [False, False, True]
    assert (found[0].found, found[0].fix) == ("/x: it is not there", "get it")
    assert "lib.so" in found[1].found
    assert found[2].found == "all of it"


def test_an_extra_that_is_not_installed_is_a_remark(doctor, monkeypatch, capsys):
    def requires(_name):
        return ["nosuchpackage>=1; extra == 'cluster'", "click>=8; extra == 'app'"]

    monkeypatch.setattr(importlib.metadata, "requires", requires)
    status, found = doctor("extras")
    assert status == 0
    assert found["extras"]["ok"]
    assert "cluster (nosuchpackage)" in found["extras"]["found"]
    assert "[cluster]'" in found["extras"]["fix"]
    assert run(["doctor", "extras"]) == 0
    remark, remedy = capsys.readouterr().out.splitlines()
    assert remark.startswith("--  extras")
    assert "if you want them" in remedy


def test_a_check_of_an_extra_that_is_not_installed_fails_only_where_it_is_asked_for(tmp_path):
    gone = "av", "cv2", "mujoco", "spacy", "sqlalchemy"
    (tmp_path / "sitecustomize.py").write_text(
        "import importlib.metadata as metadata, importlib.util as util, sys\n"
        f"gone = {gone!r}\n"
        "sys.modules.update(dict.fromkeys(gone))\n"
        "find, version = util.find_spec, metadata.version\n"
        "util.find_spec = lambda name, *rest: None if name in gone else find(name, *rest)\n"
        "def lacking(name):\n"
        "    if name.lower() in (*gone, 'opencv-python-headless'):\n"
        "        raise metadata.PackageNotFoundError(name)\n"
        "    return version(name)\n"
        "metadata.version = lacking\n"
    )
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    done = ct("doctor", "--json", cwd=tmp_path, PYTHONPATH=path)
    found = {one["name"]: one for one in json.loads(done.stdout)["checks"]}
    assert done.returncode == 0, done.stdout
    for name, extra in (("drawing", "render"), ("parsing", "language"), ("database", "app")):
        assert found[name]["ok"]
        assert f"corpus-tools-g3[{extra}]" in found[name]["fix"]
    assert ct("doctor", "parsing", cwd=tmp_path, PYTHONPATH=path).returncode == 2


def test_unknown_check(capsys):
    assert run(["doctor", "teeth"]) == 2
    message = capsys.readouterr().err
    assert "'teeth'" in message
    assert all(name in message for name in checks())


def test_a_database_that_cannot_be_reached(doctor, monkeypatch):
    monkeypatch.setenv("CT_ANNOTATE_DATABASE", "postgresql://me:secret@127.0.0.1:1/none")
    status, found = doctor("database")
    assert status == 2
    assert "secret" not in json.dumps(found)
    assert "CT_ANNOTATE_DATABASE" in found["database"]["fix"]


def test_too_little_room(doctor, monkeypatch):
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(2**40, 2**40 - 2**20, 2**20))
    status, found = doctor("disk")
    assert status == 2
    assert "0.0 GiB" in found["disk"]["found"]


def test_bash_completes_commands_and_options():
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("bash is not installed")
    script = """
    source <(ct completion bash)
    complete_ct() {
        COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
        _ct_completion ct
        echo "${COMPREPLY[@]}"
    }
    complete_ct ct docto
    complete_ct ct doctor --form
    """
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [bash, "--norc", "-c", script],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PATH": path},
    )
    assert done.stdout.split() == ["doctor", "--format"]


@pytest.mark.parametrize("shell", ["fish", "zsh"])
def test_scripts_for_other_shells(shell, capsys):
    assert run(["completion", shell]) == 0
    assert f"_CT_COMPLETE={shell}_complete" in capsys.readouterr().out
