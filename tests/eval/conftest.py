"""What tests of evaluation share."""

import pytest

from tests.eval.yard import few_annotated, yards


@pytest.fixture(autouse=True)
def quick_parsers(short_training):
    """Each held-out scenario has its parser, which learns little in these tests."""


@pytest.fixture(scope="session")
def few(tmp_path_factory):
    """Two annotated commands of two bundled scenarios, as a corpus's folder."""
    path = tmp_path_factory.mktemp("corpora") / "few"
    few_annotated().save(path)
    return str(path)


@pytest.fixture(scope="session")
def folders(few, tmp_path_factory):
    """Folders of what is learned from and of what is tested on: `few`, and the yards."""
    folder = tmp_path_factory.mktemp("corpora")
    yards(folder / "source").save(folder / "yards")
    return few, str(folder / "yards")
