"""Runs all benchmarks: ``python -m benchmarks``."""

from __future__ import annotations

import argparse
import os
import platform
from pathlib import Path

import numpy as np
import scipy

from benchmarks import candidates, extraction, logs, parsing, reading, rendering, training
from benchmarks.timing import table
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.video.drawing.gl import choose_back_end
from g3.learning.examples import examples, labels


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--corpus", default="warehouse", help="a corpus (default: warehouse)")
    parser.add_argument(
        "--slu-core", type=Path, metavar="PATH", help="the data of slu_core, rather than a corpus"
    )
    arguments = parser.parse_args()
    print(
        f"Python {platform.python_version()}, NumPy {np.__version__}, SciPy {scipy.__version__}, "
        f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"
    )
    if arguments.slu_core:
        corpus = reading.run(arguments.slu_core)
    else:
        corpus = open_corpus(arguments.corpus)
    items = examples(corpus.annotations)
    matrix = extraction.run(items)
    training.run(matrix, labels(items))
    candidates.run()
    parsing.run(corpus)
    logs.run()
    _rendering()
    table()


def _rendering() -> None:
    choose_back_end()
    try:
        rendering.run()
    except ImportError as error:
        print(f"  (left out: {error.name} is not installed)")


if __name__ == "__main__":
    main()
