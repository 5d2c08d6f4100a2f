"""A server starts on every Python that the package supports."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.core.config import Config
from tests.annotation_app.real_server import running

pytestmark = pytest.mark.slow

TELL_OF_THREADS = """
import sys, threading

def tell(event, details):
    is_parsed_here = event == "compile" and details[1] == "<unknown>" and (
        threading.current_thread() is threading.main_thread()
    )
    if is_parsed_here and threading.active_count() > 1:
        print("parsed beside", threading.enumerate(), file=sys.stderr, flush=True)

sys.addaudithook(tell)
"""


def test_code_is_parsed_before_there_are_threads(
    app: Flask, config: Config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before 3.11.8, Python fails now and then where two threads parse at once (gh-106905)."""
    (tmp_path / "sitecustomize.py").write_text(TELL_OF_THREADS)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with running(config, tmp_path) as server:
        assert server.logged() == []
        server.end()
