"""Extraction of SDCs: commands a second of one core's time, beside spaCy's own pipe."""

from __future__ import annotations

import os
import subprocess
import sys
import time

from threadpoolctl import threadpool_limits

from benchmarks.timing import best, best_of, compare, heading, show
from corpus_tools.corpus.corpus_model import Corpus
from g3.language.parsing.extractor import BATCH, default_extractor
from g3.language.parsing.spacy_pipeline import analyse, language_model

COMMANDS = 1000
LOAD = """
import time
import numpy
start = time.process_time()
from g3.language.parsing.extractor import default_extractor
from g3.language.parsing.spacy_pipeline import language_model
language_model(), default_extractor()
print(time.process_time() - start)
"""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def run(corpus: Corpus) -> None:
    """Measure on about a thousand commands of a corpus, in processor time of one thread."""
    own = [command.text for command in corpus.commands.values()]
    texts = (own * (COMMANDS // len(own) + 1))[:COMMANDS]
    heading(f"SDCs of {len(texts)} commands")
    show("import spaCy, load its model and the extractor", min(_load() for _ in range(3)), "s")
    with threadpool_limits(limits=1):
        _throughput(texts)


def _load() -> float:
    arguments = [sys.executable, "-c", LOAD]
    environment = {**os.environ, **ONE_THREAD}
    found = subprocess.run(arguments, env=environment, check=True, capture_output=True)
    return float(found.stdout)


def _throughput(texts: list[str]) -> None:
    nlp, extractor = language_model(), default_extractor()
    analyses = list(analyse(texts))
    times = best_of(
        {
            "spaCy's pipe": lambda: len(list(nlp.pipe(texts, batch_size=BATCH))),
            "text to trees": lambda: len(extractor.predict(texts)),
            "analysed text to trees": lambda: len(extractor.predict(analyses)),
        },
        clock=time.process_time,
    )
    plain = times["spaCy's pipe"][0]
    for name, (seconds, count) in times.items():
        show(name, count / seconds, "1/s", f"{plain / seconds:.2f} of spaCy's pipe")
    whole = times["text to trees"][0] / plain
    compare("text to SDC trees", "spaCy's pipe alone", whole, "spaCy's networks, which are in both")
    few = analyses[:64]
    seconds, parses = best(
        lambda: list(extractor.predict_proba(few, n_best=5)), clock=time.process_time
    )
    show("analysed text to 5 best trees", len(parses) / seconds, "1/s")
