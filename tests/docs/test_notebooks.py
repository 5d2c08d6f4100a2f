"""The notebooks run as they stand there, and are on the site and in Jupyter's format too."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from docs.notebook_pages import Cell, cells, page, run, to_ipynb
from tests.docs.blocks import ROOT
from tests.docs.small_warehouse import small_warehouse

NOTEBOOKS = ROOT / "docs/notebooks"
SMALL = """---
kernelspec:
  name: python3
---

# Title

```{code-cell} ipython3
x = 2
print("<b>", x)
x + 1
```

After it.

```{code-cell} ipython3
class Shown:
    def _repr_html_(self):
        return f"<i>{x}</i>"
Shown()
```
"""


def run_in(folder: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(folder)
    outputs = run(cells((NOTEBOOKS / name).read_text()))
    return "\n".join(f"{output.printed}{output.html}" for output in outputs)


@pytest.mark.slow
def test_from_a_bundled_corpus_to_table_1(tmp_path, monkeypatch):
    """On some of its scenarios; the site's pages are made with all of them."""
    small_warehouse(tmp_path / "warehouse")
    told = run_in(tmp_path, "table-1.md", monkeypatch)
    assert "Corpus warehouse" in told
    assert "Put the left crate on the trailer." in told
    assert "<svg" in told
    assert "Performance at predicting the correspondence variable" in told
    shares = dict(re.findall(r"^(\w+) +F (0\.\d\d), with hard", told, re.MULTILINE))
    assert float(shares["OBJECT"]) > 0.9
    assert (tmp_path / "warehouse-model.npz").exists()


@pytest.mark.slow
def test_from_your_own_episodes_to_a_rated_dataset(tmp_path, monkeypatch):
    told = run_in(tmp_path, "own-episodes.md", monkeypatch)
    assert "Corpus robot" in told
    assert "9 commands · 54 judgments" in told
    first, second = re.findall(r"^(?:original|random): ([01]\.\d\d) of \d+", told, re.MULTILINE)
    assert float(first) > 0.7 > 0.3 > float(second)
    assert (tmp_path / "rated-slu-core").is_dir()


def test_cells_and_outputs():
    found = cells(SMALL)
    assert [cell.kind for cell in found] == ["markdown", "code", "markdown", "code"]
    first, second = run(found)
    assert (first.printed, first.html) == ("<b> 2\n3\n", "")
    assert (second.printed, second.html) == ("", "<i>2</i>")
    shown = page(SMALL)
    assert "```text\n<b> 2\n3\n```" in shown
    assert '<div class="cell-output"><i>2</i></div>' in shown


def test_a_command_that_fails_stops_the_notebook():
    with pytest.raises(RuntimeError, match="no folder or bundled corpus"):
        list(run([Cell("code", "!ct corpus stats nowhere")]))


@pytest.mark.parametrize("name", [path.name for path in sorted(NOTEBOOKS.glob("*.md"))])
def test_jupyters_format(name):
    text = (NOTEBOOKS / name).read_text()
    made = json.loads(to_ipynb(text))
    assert (made["nbformat"], made["nbformat_minor"]) == (4, 5)
    assert ["".join(c["source"]) for c in made["cells"]] == [c.source for c in cells(text)]
    code = [c for c in made["cells"] if c["cell_type"] == "code"]
    assert all(c["outputs"] == [] and c["execution_count"] is None for c in code)
    assert len({c["id"] for c in made["cells"]}) == len(made["cells"])
