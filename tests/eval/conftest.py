"""What tests of evaluation share."""

import pytest

from corpus_tools.corpus.corpus_writing import write_corpus
from tests.eval.yard import few_annotated, yards


@pytest.fixture(scope="session")
def few(tmp_path_factory):
    """Two annotated commands of two bundled scenarios, as a corpus's folder."""
    path = tmp_path_factory.mktemp("corpora") / "few"
    write_corpus(few_annotated(), path)
    return str(path)


@pytest.fixture(scope="session")
def folders(few, tmp_path_factory):
    """Folders of what is learned from and of what is tested on: `few`, and the yards."""
    folder = tmp_path_factory.mktemp("corpora")
    write_corpus(yards(folder / "source"), folder / "yards")
    return few, str(folder / "yards")
