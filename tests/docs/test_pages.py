"""Pages that are there, are found, and lead to what is there."""

from __future__ import annotations

import ast
import csv
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from corpus_tools.following.bundled_grounder import kept_at
from corpus_tools.importers.authored.bundled import open_corpus
from ct.acting import _bundled
from docs.make_potentials import listed
from docs.notebook_pages import cells
from g3.features import feature_registry as registry
from g3.inference.potentials.potential_registry import KINDS, potentials
from g3.learning.grounding_model import GroundingModel
from tests.docs.blocks import ROOT, pages
from tests.docs.small_warehouse import small_warehouse

DOCS = ROOT / "docs"
MOST_WORDS = 38_000
"""Length of the documentation with README and code, in words."""
MADE = DOCS / "_made"
LINK = re.compile(r"\]\(([^)#\s:]+)(?:#[^)]*)?\)")
TOCTREE = re.compile(r"```{toctree}\n.*?\n\n(.*?)```", re.DOTALL)
PACKAGES = ("ct", "g3", "corpus_tools", "eval", "annotation_app")
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", [pytest.param(p, id=str(p.relative_to(ROOT))) for p in pages()])
def test_links_lead_somewhere(page: Path) -> None:
    targets = {(page.parent / target).resolve() for target in LINK.findall(page.read_text())}
    gone = [t for t in targets if not t.exists() and t.parent != MADE]
    assert not gone


def test_the_documentation_stays_short() -> None:
    texts = [file.read_text() for file in (ROOT / "README.md", *DOCS.rglob("*.md"))]
    assert sum(len(text.split()) for text in texts) <= MOST_WORDS


def test_the_architecture_names_modules_and_folders_that_exist() -> None:
    """Names such as `items/assignment` end the path of a module, a folder or a file."""
    named = set(re.findall(r"`((?:\w+/)+[\w.]+)/?`", (DOCS / "architecture.md").read_text()))
    files = [p for top in (*PACKAGES, "tests", "docs", "datasets") for p in (ROOT / top).rglob("*")]
    paths = {f"/{p.relative_to(ROOT).with_suffix('').as_posix()}" for p in files}
    gone = [name for name in named if not any(p.endswith(_path(name)) for p in paths)]
    assert len(named) > 50
    assert not gone


def _path(name: str) -> str:
    return f"/{Path(name).with_suffix('').as_posix()}"


def test_every_page_is_in_the_sites_contents() -> None:
    contents = "\n".join(TOCTREE.findall((DOCS / "index.md").read_text()))
    listed = re.sub(r"^.* <(.+)>$", r"\1", contents, flags=re.MULTILINE).split()
    there = {p.relative_to(DOCS).with_suffix("").as_posix() for p in DOCS.rglob("*.md")}
    assert sorted(listed) == sorted(there - {"index"})


@pytest.mark.parametrize("page", [pytest.param(p, id=str(p.relative_to(ROOT))) for p in pages()])
def test_python_is_python(page: Path) -> None:
    for block in PYTHON.findall(page.read_text()):
        ast.parse(block)


def test_python_that_registers_is_in_an_example() -> None:
    """The how-tos show what the examples do: the same names, imported from the same places."""
    for name, file in (
        ("new-object-type", "cable_reel/cable_reel/kinds.py"),
        ("new-feature", "tabletop_blocks/tabletop_blocks/features.py"),
        ("new-task", "paraphrase/paraphrase_task/task.py"),
    ):
        (block,) = PYTHON.findall((DOCS / f"how-to/{name}.md").read_text())
        example = (ROOT / "examples" / file).read_text()
        assert _imports(block) <= _imports(example)


def test_the_grounder_that_is_shown_is_the_examples() -> None:
    (block,) = PYTHON.findall((DOCS / "how-to/own-grounder.md").read_text())
    example = (ROOT / "examples/fuzzy_labels/fuzzy_labels/fuzzy_grounder.py").read_text()
    assert example.endswith(block)
    assert len([line for line in block.splitlines() if line]) <= 36


def _imports(code: str) -> set[tuple[str | None, str]]:
    nodes = (n for n in ast.walk(ast.parse(code)) if isinstance(n, ast.ImportFrom))
    return {(n.module, alias.name) for n in nodes for alias in n.names}


@pytest.mark.slow
@pytest.mark.usefixtures("short_training")
def test_the_models_python_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code = "\n".join(PYTHON.findall((DOCS / "model.md").read_text()))
    small_warehouse(tmp_path / "warehouse")
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "model.md", "exec"), {})
    made = {path.name for path in tmp_path.iterdir()} - {"warehouse"}
    assert sorted(made) == ["g3.json", "g3.npz"]
    assert len(capsys.readouterr().out.split()) == 3


@pytest.fixture
def quick_model(
    trained: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[None]:
    """In an empty cache, a model of one bundled scenario where that of several of them is kept."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    small_warehouse(tmp_path / "warehouse")
    monkeypatch.chdir(tmp_path)
    corpus = open_corpus("warehouse")
    model = GroundingModel.load(trained("one-scenario"))
    model.card = {**(model.card or {}), "corpus_hash": corpus.hash}
    model.save(kept_at(corpus.hash))
    _bundled.cache_clear()
    yield
    _bundled.cache_clear()


@pytest.mark.slow
@pytest.mark.usefixtures("quick_model")
def test_the_readmes_python_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = PYTHON.findall((ROOT / "README.md").read_text())
    exec(compile(code, "README.md", "exec"), {})
    told = capsys.readouterr().out
    assert "OBJECT  |" in told
    assert "pick up" in told
    assert {"model.npz", "model.json"} <= {path.name for path in tmp_path.iterdir()}


def test_a_new_feature_can_be_registered_as_shown() -> None:
    (code,) = PYTHON.findall((DOCS / "how-to/new-feature.md").read_text())

    try:
        exec(compile(code, "new-feature.md", "exec"), {})
        assert "my-path-end" in {s.name for s in registry.catalogue()}
    finally:
        registry.FEATURES.remove("my-path-end")


def test_each_promise_of_the_security_page_has_a_test() -> None:
    text = (DOCS / "security.md").read_text()
    rows = [row for row in text.splitlines() if row.startswith("| ") and row.count("|") == 3]
    named = [re.findall(r"`((?:\w+/)*test_\w+\.py)`", row.split("|")[2]) for row in rows[2:]]
    assert len(named) > 10
    assert all(named)
    tests = ROOT / "tests"
    for name in {name for names in named for name in names}:
        assert (tests / name).exists() or (tests / "annotation_app" / name).exists(), name


def test_every_potential_is_listed_with_its_record() -> None:
    """Without a record where a rule is new; `docs/make_potentials.py` writes the table."""
    with (DOCS / "contributing/potentials.csv").open(encoding="utf-8", newline="") as stream:
        _, *rows = csv.reader(stream)
    assert [row[:6] for row in rows] == [
        listed(rule) for kind in KINDS for rule in potentials() if rule.kind == kind
    ]
    assert all(re.fullmatch(r"(\d+, \d+ \(\d+\))?", cell) for row in rows for cell in row[6:-1])
    page = (DOCS / "contributing/potentials.md").read_text()
    assert all(f"| `{kind}` | {about} |\n" in page for kind, about in KINDS.items())


def test_every_public_module_is_in_the_reference() -> None:
    """Public is what pages, notebooks and examples import, and what `ct` hands over to."""
    codes = [block for page in pages() for block in PYTHON.findall(page.read_text())]
    notebooks = [cells(path.read_text()) for path in (DOCS / "notebooks").glob("*.md")]
    codes += [
        re.sub("^!.*$", "", cell.source, flags=re.MULTILINE)
        for notebook in notebooks
        for cell in notebook
        if cell.kind == "code"
    ]
    files = [*(ROOT / "examples").rglob("*.py"), *(ROOT / "ct").glob("*.py")]
    codes += [path.read_text() for path in files]
    public = {_module(source, name) for code in codes for source, name in _imports(code) if source}
    ours = {name for name in public if name.split(".")[0] in PACKAGES}
    assert len(ours) > 60
    page = (DOCS / "reference/python.md").read_text()
    listed = re.findall(
        r"^(?:\.\. automodule:: )?((?:\w+\.)*\w+)(?: without \w+)?$", page, re.MULTILINE
    )
    assert sorted(ours - set(listed)) == []
    assert len(listed) == len(set(listed))


def _module(source: str, name: str) -> str:
    """What is imported from, or the module that is imported."""
    file = ROOT / f"{source.replace('.', '/')}/{name}.py"
    return f"{source}.{name}" if file.exists() else source
