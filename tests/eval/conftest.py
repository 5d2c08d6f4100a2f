"""What tests of evaluation share."""

import pytest

from corpus_tools.corpus.corpus_writing import write_corpus
from corpus_tools.corpus.encoding import make_corpus
from corpus_tools.importers.authored.bundled import open_corpus

COMMANDS = ("court_put_crate_on_trailer-01", "hall_pick_up_boxes-01")


@pytest.fixture(scope="session")
def few(tmp_path_factory):
    """Two annotated commands of two bundled scenarios, as a corpus's folder."""
    whole = open_corpus("warehouse")
    annotations = [a for a in whole.annotations if a.command.id in COMMANDS]
    corpus = make_corpus(
        name="few",
        contexts=list({a.context.id: a.context for a in annotations}.values()),
        commands=list({a.command.id: a.command for a in annotations}.values()),
        annotations=annotations,
        judgments=[],
        source=whole.source,
        licence=whole.licence,
    )
    path = tmp_path_factory.mktemp("corpora") / "few"
    write_corpus(corpus, path)
    return str(path)
