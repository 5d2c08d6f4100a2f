"""One command for every figure of benchmarks/README.md."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = ROOT / "benchmarks" / "README.md"
NO_TIMING = {"arguments"}


def listed(*arguments):
    command = [sys.executable, "-m", "benchmarks.everything", "--list", *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, check=True, cwd=ROOT
    ).stdout.splitlines()


@pytest.fixture(scope="module")
def everything():
    return listed()


def test_every_benchmark_that_the_page_names_is_run(everything):
    named = set(re.findall(r"python -m benchmarks\.(\w+)", README.read_text())) - {"everything"}
    whole = set(re.findall(r"\b(\w+)\.run\(", (ROOT / "benchmarks" / "__main__.py").read_text()))
    run = {m for line in everything for m in re.findall(r"-m benchmarks\.(\w+)", line)}
    assert "python -m benchmarks" in everything
    assert named - NO_TIMING <= run | whole
    assert {"jobs", "inference", "app_submissions", "shards"} <= run


def test_simulated_corpora_that_are_there_are_not_made_again(tmp_path, everything):
    assert sum("simulate-workers" in line for line in everything) == 7
    for seed in (101, 108):
        (tmp_path / "simulated" / str(seed)).mkdir(parents=True)
    left = listed("--folder", str(tmp_path), "--only", "simulate-workers")
    assert len(left) == 5
    assert not any("--seed 101" in line for line in left)


def test_some_are_run_and_failures_are_counted(tmp_path):
    # Shards of no corpora: the command says so.
    command = [sys.executable, "-m", "benchmarks.everything", "--folder", str(tmp_path)]
    done = subprocess.run(
        [*command, "--only", "wordless"], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 1
    assert "=== 1 of 1: python -m benchmarks.training" in done.stdout
    assert "failed: python -m benchmarks.training" in done.stdout
