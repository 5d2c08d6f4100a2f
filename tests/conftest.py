from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.report import ImportReport

# The cores are busy with other workers; NumPy and SciPy read this when they are loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Programs that tests start would compile all modules each time.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# The search for cycles takes a seventh of the time otherwise.
gc.set_threshold(50_000, 10, 10)

# For a format that no schema here has, jsonschema would build grammars for seconds.
sys.modules.setdefault("rfc3987_syntax", None)

# A shell's background jobs ignore Ctrl-C, and so would all programs that the tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

PUBLISHED = Path(__file__).parents[2] / "shared" / "data" / "slu_core" / "data"

# The machine may be busy: how long one example takes says nothing.
# The checks try the same examples every time; `pytest --hypothesis-profile explore` tries others.
settings.register_profile("checks", deadline=None, derandomize=True, max_examples=30)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile("checks")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that have slow tests, so that none of them is left for the end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(scope="session")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Gives the files of small models (`tests/small_models.py`), trained once a run."""
    from tests.small_models import trained_in  # noqa: PLC0415 - few tests need it

    base = tmp_path_factory.getbasetemp()
    folder = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    return lambda name: trained_in(folder, name)


@pytest.fixture
def short_training(monkeypatch: pytest.MonkeyPatch) -> None:
    """Train parsers by a tenth of the steps, where it doesn't matter how much they learn."""
    from g3.language.parsing.training import parser_training  # noqa: PLC0415

    monkeypatch.setattr(parser_training, "LEAST_STEPS", parser_training.LEAST_STEPS // 10)


@pytest.fixture(scope="session")
def published_files() -> Path:
    """The authors' release, where it is at hand."""
    if not PUBLISHED.is_dir():
        pytest.skip(f"the published corpus is not at {PUBLISHED}")
    return PUBLISHED


@pytest.fixture(scope="session")
def published(published_files: Path) -> tuple[Corpus, ImportReport]:
    """The authors' release, imported."""
    from corpus_tools.importers.slu_core.slu_corpus import import_slu_core  # noqa: PLC0415

    return import_slu_core(published_files, salt="salt")
