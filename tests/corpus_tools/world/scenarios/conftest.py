from __future__ import annotations

import pytest

from tests.corpus_tools.world.scenarios.floor import LAYOUT, SCENARIO


@pytest.fixture
def write(tmp_path):
    """Writes a dataset with one scenario; gives its file."""

    def make(scenario=SCENARIO, layout=LAYOUT):
        for name in ("scenarios", "layouts"):
            (tmp_path / name).mkdir(exist_ok=True)
        (tmp_path / "layouts" / "floor.yaml").write_text(layout)
        file = tmp_path / "scenarios" / "x.yaml"
        file.write_text(scenario)
        return file

    return make
