"""Parsing of commands against spaCy's own pipe: ``python -m benchmarks.parsing CORPUS``."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from threadpoolctl import threadpool_limits

from benchmarks.timing import best_of, row
from corpus_tools.importers.authored.bundled import open_corpus
from g3.language.parsing.sdc_parser import default_parser
from g3.language.parsing.spacy_pipeline import language_model

COMMANDS = 1000


def main(corpus: str) -> None:
    """Measure on about a thousand commands of a corpus, in processor time of one thread."""
    own = [command.text for command in open_corpus(corpus).commands.values()]
    texts = (own * (COMMANDS // len(own) + 1))[:COMMANDS]
    with threadpool_limits(limits=1):
        nlp, parser = language_model(), default_parser()
        actions: dict[str, Callable[[], object]] = {
            "spaCy's pipe": lambda: list(nlp.pipe(texts)),
            "text to trees": lambda: parser.predict(texts),
        }
        seconds = {
            name: taken for name, (taken, _) in best_of(actions, clock=time.process_time).items()
        }
    rate = f"{len(texts) / seconds['text to trees']:.0f} commands/s"
    ratio = seconds["text to trees"] / seconds["spaCy's pipe"]
    row("text to SDC trees", rate, f"{ratio:.2f} of spaCy's pipe")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "warehouse")
