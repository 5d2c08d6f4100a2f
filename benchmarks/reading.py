"""Import of the published corpus against plain YAML parsing: ``python -m benchmarks.reading DATA``.

``DATA`` is the folder `data` of a clone of slu_core.
"""

from __future__ import annotations

import bz2
import sys
import tempfile
from pathlib import Path

import yaml

from benchmarks.timing import best, row
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.slu_core.slu_corpus import import_slu_core


def main(data: Path) -> None:
    seconds, (corpus, _) = best(lambda: import_slu_core(data, salt="benchmark"), repeats=1)
    names = ("assignments.yaml", "evaluations.yaml", "evaluations.run1.yaml")
    contents = [path.read_bytes() for name in names for path in data.rglob(name)]
    contents += [bz2.decompress(path.read_bytes()) for path in data.rglob("*.yaml.bz2")]
    loader = yaml.CSafeLoader
    peer, _ = best(lambda: [yaml.load(c, Loader=loader) for c in contents], repeats=1)
    what = f"import of slu_core, {len(corpus.annotations)} annotations"
    row(what, f"{seconds:.1f} s", f"{seconds / peer:.2f} of PyYAML's CSafeLoader on the same files")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "corpus"
        corpus.save(path)
        again, _ = best(lambda: Corpus.load(path))
    row("reading the imported corpus", f"{again:.2f} s", f"{again / seconds:.2f} of the import")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
