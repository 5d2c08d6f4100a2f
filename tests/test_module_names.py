"""A module's name is unique in the project, so that a name says which file is meant."""

from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("g3", "corpus_tools", "annotation_app", "eval", "ct", "benchmarks", "examples")


def test_no_two_modules_share_a_name():
    names = [path.stem for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
    counts = Counter(name for name in names if not name.startswith("__"))
    assert len(counts) > 500  # it has looked
    assert [name for name, count in counts.items() if count > 1] == []
