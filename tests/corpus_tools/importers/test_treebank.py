"""Treebanks as corpora, from the command line."""

from __future__ import annotations

import json

import pytest

from corpus_tools.cli.console import run
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.importers.treebank import read_second_trees, read_treebank
from corpus_tools.runtime.shipped import bundled
from g3.errors import FormatError
from g3.sdc.sdc_notation import format_brackets
from tests.small_treebank import write_treebank


@pytest.fixture
def treebank(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return write_treebank(tmp_path / "mine")


@pytest.fixture
def ct(capsys):
    def told(*arguments: object) -> tuple[int, str, str]:
        status = run([str(argument) for argument in arguments])
        return status, *capsys.readouterr()

    return told


def change(file, old, new):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def test_a_folder_of_trees_is_read_like_any_corpus(ct, treebank):
    status, out, _ = ct("corpus", "stats", treebank, "--json")
    counted = json.loads(out)
    assert status == 0
    names = ("commands", "subjects", "contexts", "scenarios")
    assert [counted[name] for name in names] == [16, 4, 2, ["writer-1", "writer-2"]]
    assert counted["sdcs_by_type"] == {"EVENT": 12, "OBJECT": 28, "PLACE": 4, "PATH": 8}
    assert ct("corpus", "validate", treebank)[:2] == (0, f"{treebank}: no problems\n")


def test_words_that_are_taken_back_and_commands_that_ask_for_nothing_are_shown(ct, treebank):
    _, out, _ = ct("corpus", "show", treebank, "p1-3/positive")
    assert "EVENT_1(r = Go, l = PATH_2(r = to, l = OBJ_3(f = the truck)))" in out
    assert "taken back: to the pallet" in out
    _, out, _ = ct("corpus", "show", treebank, "p1-4/positive")
    assert "asks for nothing" in out


def test_a_repeated_word_is_not_the_one_that_is_taken_back(treebank):
    command = {one.id: one for one in read_treebank(treebank)}["p1-3"]
    assert command.text == "Go to the pallet, no, to the truck."
    path = command.trees[0].landmark1[0]
    assert [word.start for word in path.relation] == [22]
    assert [word.start for word in path.landmark1[0].words] == [25, 29]
    assert [word.start for word in command.taken_back] == [3, 6, 10]


def test_what_is_imported_is_exported_as_it_was(ct, treebank, tmp_path):
    corpus, again = tmp_path / "corpus", tmp_path / "again"
    status, out, _ = ct("import", "treebank", treebank, "--out", corpus)
    assert status == 0
    assert "4 commands that ask for nothing" in out
    assert ct("corpus", "export", corpus, "--to", "treebank", "--out", again)[0] == 0
    assert read_treebank(again) == read_treebank(treebank)
    assert open_corpus(again).hash == open_corpus(corpus).hash == open_corpus(treebank).hash


def test_any_corpus_can_be_a_treebank(ct, treebank, tmp_path):
    again = tmp_path / "again"
    assert ct("corpus", "export", "warehouse", "--to", "treebank", "--out", again)[0] == 0
    warehouse, found = open_corpus("warehouse"), open_corpus(again)
    assert {e.id: e.sdcs for e in found} == {e.id: e.sdcs for e in warehouse}


def test_trees_keep_their_words_where_a_reader_would_find_others(ct, treebank, tmp_path):
    placed = "EVENT(r = Go@0, l = PATH(r = to@22, l = OBJ(f = the@6 truck@29)))"
    plain = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))"
    change(treebank / "trees.jsonl", f'no, to the truck.", "trees": ["{plain}"], "taken_back": '
           '"to the pallet"', f'no, to the truck.", "trees": ["{placed}"]')  # fmt: skip
    again = tmp_path / "again"
    assert ct("corpus", "export", treebank, "--to", "treebank", "--out", again)[0] == 0
    assert read_treebank(again) == read_treebank(treebank)


def test_one_file_is_enough(ct, treebank):
    (treebank / "people.jsonl").unlink()
    (treebank / "trees.jsonl").write_text(
        '{"id": "1", "text": "Go there.", "trees": ["EVENT(r = Go, l = PLACE(r = there))"]}\n'
    )
    _, out, _ = ct("corpus", "show", treebank, "1", "--json")
    [command] = json.loads(out)["commands"]
    assert command == {"id": "1", "text": "Go there.", "scenario": "commands"}


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("PLACE(r = on, l = OBJ(f = the truck))", "PLACE(r = on", "expected"),
        ("OBJ(f = the truck)", "OBJ(f = the lorry)", "the word 'lorry' is not in the command"),
        ('"taken_back": "to the pallet"', '"taken_back": "to the crate"', "'crate' is not in"),
        ('"id": "p1-2"', '"id": "p1-1"', "another command has the id"),
        ('"person": "p1"', '"person": "p9"', "there is no person 'p9'"),
    ],
)
def test_problems_name_the_row_and_can_be_left_out(ct, treebank, tmp_path, old, new, problem):
    change(treebank / "trees.jsonl", old, new)
    status, _, err = ct("corpus", "stats", treebank)
    assert (status, problem in err) == (2, True)
    assert "trees.jsonl:" in err
    status, out, _ = ct("import", "treebank", treebank, "--out", tmp_path / "c", "--keep-going")
    assert (status, problem in out) == (0, True)
    assert len(open_corpus(tmp_path / "c")) == 15


def test_the_bundled_treebank_has_what_its_readme_says():
    folder = bundled()["treebank"]
    commands, second = read_treebank(folder), read_second_trees(folder)
    assert len(commands) == 11418
    assert len({one.person for one in commands}) == 336
    assert sum(not one.trees for one in commands) == 334
    assert sum(bool(one.taken_back) for one in commands) == 707
    assert len({one.split_group for one in commands}) == 33
    assert len(second) == 400
    land = next(one for one in commands if one.id == "p55-31")
    assert format_brackets(land.trees, positions=True).startswith("EVENT_1(r = Land@32")


def test_a_second_annotation_of_an_unknown_command_is_refused(treebank):
    (treebank / "second.jsonl").write_text('{"id": "p7-1", "trees": []}\n')
    with pytest.raises(FormatError, match="there is no command 'p7-1'"):
        read_second_trees(treebank)
