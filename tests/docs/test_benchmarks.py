"""One command for every figure of benchmarks/README.md."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = ROOT / "benchmarks" / "README.md"
NO_TIMING = {"argument_scores"}
IN_THE_FIRST = {"candidates", "logs"}
"""What `python -m benchmarks` runs just as they do by themselves."""


def listed(*arguments):
    command = [sys.executable, "-m", "benchmarks.everything", "--list", *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, check=True, cwd=ROOT
    ).stdout.splitlines()


@pytest.fixture(scope="module")
def everything():
    return listed()


def test_every_benchmark_that_the_page_names_is_run_as_it_says(everything):
    page = README.read_text()
    named = set(re.findall(r"python -m benchmarks\.(\w+)", page)) - {"everything"}
    run = {m for line in everything for m in re.findall(r"-m benchmarks\.(\w+)", line)}
    assert "python -m benchmarks" in everything
    assert named - NO_TIMING - IN_THE_FIRST <= run
    shown = [line.split("#")[0].split() for line in page.splitlines() if line[:7] == "python "]
    # Folders are the reader's; the rest is run as it is written.
    said = [[w for w in words[3:] if w[:1] == "-" or w[:1].isdigit()] for words in shown]
    for words, options in zip(shown, said, strict=True):
        if words[2] in ("benchmarks", "benchmarks.everything"):
            continue
        lines = [line.split() for line in everything if words[2] in line.split()]
        assert any(set(options) <= set(line) for line in lines), words
    assert sum(map(len, said)) > 10


def test_only_some_in_a_folder_of_ones_own(tmp_path):
    lines = listed("--folder", str(tmp_path), "--only", "simulate-workers")
    assert len(lines) == 7
    assert all(f"--out {tmp_path / 'simulated'}" in line for line in lines)


def test_what_grows_alone(everything, tmp_path):
    lines = listed("--quick", "--corpus", "aaai11", "--beside", str(tmp_path))
    assert len(lines) < len(everything) / 2
    named = {line.split()[2] for line in lines}
    assert named <= {line.split()[2] for line in everything}
    (beside,) = (line for line in lines if "app_submissions" in line)
    assert beside.endswith(f"--beside {tmp_path}")


def test_some_are_run_and_failures_are_counted(tmp_path):
    # Shards of no corpora: the command says so.
    command = [sys.executable, "-m", "benchmarks.everything", "--folder", str(tmp_path)]
    done = subprocess.run(
        [*command, "--only", "wordless"], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 1
    assert "=== 1 of 1: python -m benchmarks.training" in done.stdout
    assert "failed: python -m benchmarks.training" in done.stdout
