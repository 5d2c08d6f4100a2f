"""Formats by name, from the command line and from other distributions."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from corpus_tools.cli.console import run
from corpus_tools.exporters.export_registry import (
    EXPORTERS,
    Exporter,
    export_corpus_to,
    exporters,
    register,
)
from g3.errors import FormatError
from tests.tiny_corpus import tiny_corpus


def commands_only(corpus, videos):
    return {"commands.txt": "\n".join(c.text for c in corpus.commands.values()).encode()}


def test_the_formats_have_a_line_each():
    found = {exporter.name: exporter.summary for exporter in exporters()}
    assert set(found) >= {"conllu", "csv", "huggingface", "label-studio", "lerobot", "slu-core"}
    assert all(len(summary) < 80 for summary in found.values())
    assert all(callable(exporter.load()) for exporter in exporters())


def test_others_can_add_formats(monkeypatch, request, tmp_path: Path):
    mine = Exporter("mine", "Texts.", f"{__name__}:commands_only", "commands.txt", True)
    monkeypatch.setattr(Exporter, "load", lambda self: commands_only)
    register(mine)
    request.addfinalizer(lambda: EXPORTERS.remove("mine"))
    corpus = tiny_corpus()
    assert export_corpus_to(corpus, "mine", tmp_path / "out") == ("commands.txt",)
    texts = (tmp_path / "out" / "commands.txt").read_text().splitlines()
    assert texts == [c.text for c in corpus.commands.values()]
    with pytest.raises(ValueError, match="already"):
        register(mine)


def test_errors_say_what_to_do(tmp_path: Path):
    corpus = tiny_corpus()
    with pytest.raises(FormatError, match="there is no format 'doc'") as error:
        export_corpus_to(corpus, "doc", tmp_path / "out")
    assert "huggingface" in error.value.fix
    with pytest.raises(FormatError, match="has no videos"):
        export_corpus_to(corpus, "csv", tmp_path / "out", videos=tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    with pytest.raises(FormatError, match="holds other things"):
        export_corpus_to(corpus, "csv", tmp_path / "mine", force=True)
    export_corpus_to(corpus, "csv", tmp_path / "out")
    with pytest.raises(FormatError, match="there already"):
        export_corpus_to(corpus, "csv", tmp_path / "out")
    export_corpus_to(corpus, "csv", tmp_path / "out", force=True)


def test_from_the_command_line(capsys, tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def ct(*arguments: str) -> tuple[int, str, str]:
        status = run(list(arguments))
        return status, *capsys.readouterr()

    status, out, _ = ct("corpus", "formats")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == [e.name for e in exporters()]
    status, out, _ = ct("corpus", "export", "warehouse", "--to", "csv", "--out", "w", "--json")
    assert status == 0
    assert json.loads(out)["files"] == sorted(file.name for file in (tmp_path / "w").iterdir())
    status, _, err = ct("corpus", "export", "warehouse", "--to", "doc", "--out", "d")
    assert (status, "there is no format 'doc'" in err) == (2, True)
