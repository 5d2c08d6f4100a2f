from __future__ import annotations

import pytest

from corpus_tools.cli.import_commands import import_
from corpus_tools.importers.importer_registry import Importer, importers, register


def test_every_importer_can_be_loaded_and_is_a_command():
    for importer in importers():
        assert callable(importer.load())
        assert importer.summary in import_.commands[importer.name].help


def test_a_name_is_registered_once():
    with pytest.raises(ValueError, match="slu-core"):
        register(Importer("slu-core", "", "", "a:b"))
