"""Names of files as other systems write them."""

from __future__ import annotations

import unicodedata
from pathlib import Path

import pytest

from corpus_tools.tables.file_names import find_file, is_shadow


@pytest.mark.parametrize(("on_disk", "in_table"), [("NFD", "NFC"), ("NFC", "NFD"), ("NFC", "NFC")])
def test_a_file_is_found_however_its_accents_are_stored(
    tmp_path: Path, on_disk: str, in_table: str
) -> None:
    file = tmp_path / unicodedata.normalize(on_disk, "Küche/café.mp4")
    file.parent.mkdir()
    file.touch()
    assert find_file(tmp_path, unicodedata.normalize(in_table, "Küche/café.mp4")) == file
    assert find_file(tmp_path, unicodedata.normalize(in_table, "Küche\\café.mp4")) == file


@pytest.mark.parametrize("name", ["x.mp4", "no/x.mp4", "x" * 100_000, "a\\b.mp4", "../x.mp4"])
def test_a_file_that_is_not_there_is_the_one_named(tmp_path: Path, name: str) -> None:
    assert find_file(tmp_path, name) == tmp_path / name


def test_files_of_other_systems_are_known() -> None:
    shadows = ["._push.mp4", ".DS_Store", "Thumbs.db", "thumbs.db", "desktop.ini", "~$push.csv"]
    shadows += ["__MACOSX/push.mp4", "@eaDir/push.mp4", ".~lock.t.csv#"]
    assert all(is_shadow(Path(name)) for name in shadows)
    assert not any(is_shadow(Path(n)) for n in ["push.mp4", "a._b.mp4", "~push.mp4", "clips/x.mp4"])
