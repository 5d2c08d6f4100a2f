"""The check of prose finds idioms where they are, and leaves code and quotations alone."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from docs.prose_report import check, mean_sentence
from tests.docs.blocks import ROOT

PAGE = """# Title

Errors are told on the terminal.

```text
what was told
```

It shows "whoever told it" and `told`.
"""
MODULE = '''"""Whether it works."""

import click


def price() -> int:
    """Return what it costs.

    The name tells more.
    """


OPTION = click.option("--x", help="For whom it is.")
'''


def test_idioms_of_a_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    assert [(found.line, found.phrase) for found in check(page)] == [(3, "told")]


def test_idioms_and_openings_of_a_module(tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.write_text(MODULE)
    assert [(found.line, found.phrase) for found in check(module)] == [
        (1, "Whether …"),
        (7, "what it costs"),
        (9, "tells"),
        (13, "For whom"),
    ]


def test_long_sentences_are_counted_without_code_and_tables() -> None:
    short = "This sentence has six words here.\n\n" * 5
    assert mean_sentence(f"{short}\n| a table | {'word ' * 90} |\n") == 6
    assert mean_sentence("word " * 100) == 0, "too few sentences"


@pytest.mark.parametrize(("text", "status"), [("All is well.\n", 0), (PAGE, 1)])
def test_the_exit_status_shows_whether_there_is_any(tmp_path: Path, text: str, status: int) -> None:
    page = tmp_path / "page.md"
    page.write_text(text)
    command = [sys.executable, "docs/prose_report.py", str(page)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == status
    assert bool(done.stdout) == bool(status)
