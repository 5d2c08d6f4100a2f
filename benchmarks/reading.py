"""Import of the published corpus against plain YAML parsing, and reading it again."""

from __future__ import annotations

import bz2
import tempfile
from pathlib import Path

from benchmarks.timing import best, compare, heading, show
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.corpus.corpus_writing import write_corpus
from corpus_tools.importers.slu_core.slu_corpus import import_slu_core


def run(data: Path) -> Corpus:
    """Measure on the `data` folder of a clone of slu_core; return its corpus."""
    heading(f"Reading {data}")
    seconds, (corpus, _) = best(lambda: import_slu_core(data, salt="benchmark"), repeats=1)
    show("import", seconds, "s", f"{len(corpus.annotations)} annotations")
    _compare_with_yaml(data, seconds)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "corpus"
        writing, _ = best(lambda: write_corpus(corpus, path), repeats=1)
        reading, _ = best(lambda: load_corpus(path))
    show("write the corpus", writing, "s")
    show("read the corpus again", reading, "s")
    show("read again / import", reading / seconds, "")
    return corpus


def _compare_with_yaml(data: Path, ours: float) -> None:
    try:
        import yaml  # noqa: PLC0415 - may be missing
    except ImportError:
        print("  (no comparison with plain YAML parsing: PyYAML is not installed)")
        return
    loader = getattr(yaml, "CSafeLoader", None)
    if loader is None:
        print("  (no comparison with plain YAML parsing: PyYAML has no libyaml)")
        return
    names = ("assignments.yaml", "evaluations.yaml", "evaluations.run1.yaml")
    contents = [path.read_bytes() for name in names for path in data.rglob(name)]
    contents += [bz2.decompress(path.read_bytes()) for path in data.rglob("*.yaml.bz2")]

    def parse() -> None:
        for content in contents:
            yaml.load(content, Loader=loader)

    seconds, _ = best(parse, repeats=1)
    show("parse the same files, PyYAML's CSafeLoader", seconds, "s")
    compare("import", "PyYAML's CSafeLoader", ours / seconds, "reading the files from the disk")
