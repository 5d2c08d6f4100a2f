"""The benchmarks of benchmarks/README.md."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from tests.docs.blocks import ROOT

README = ROOT / "benchmarks" / "README.md"


def benchmarks(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "benchmarks", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)


def test_the_page_names_benchmarks_that_there_are() -> None:
    measured, _, _ = README.read_text(encoding="utf-8").partition("## Own code")
    named = re.findall(r"\| `(\w+)[^|]*` \|", measured)
    there = {path.stem for path in (ROOT / "benchmarks").glob("*.py")}
    assert len(set(named)) > 15
    assert set(named) <= there


def test_all_that_are_timed_are_in_the_page() -> None:
    lines = benchmarks("--list", "--slu-core", "data").stdout.splitlines()
    page = README.read_text(encoding="utf-8")
    assert all(f"`{line.split()[0]}" in page for line in lines)


def test_some_are_run_and_failures_are_counted(tmp_path: Path) -> None:
    done = benchmarks("--corpus", str(tmp_path), "--only", "parsing")
    assert done.returncode == 1
    assert f"failed: parsing {tmp_path}" in done.stdout
