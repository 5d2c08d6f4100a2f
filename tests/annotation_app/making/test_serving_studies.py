"""What `ct annotate --studies` serves."""

from __future__ import annotations

import urllib.request
from pathlib import Path

from annotation_app.core.config import Config
from tests.annotation_app.real_server import running

STUDY = "name: arm\ntitle: {title}\nvideos: clips\ntasks:\n  describe: {{}}\n"


def test_files_are_read_at_each_start_and_a_wrong_one_stops_no_other(
    config: Config, root: Path, tmp_path: Path
) -> None:
    (root / "bad.yaml").write_text("name: bad\n")
    for title in ("First", "Second"):
        (root / "arm.yaml").write_text(STUDY.format(title=title))
        with running(config, tmp_path, "--studies", str(root)) as server:
            assert "study arm: " in server.told
            told = server.log.read_text()
            assert "bad.yaml:1:1: the field 'title' is missing" in told
            assert "bad.yaml has changed nothing" in told
            with urllib.request.urlopen(f"http://localhost:{server.port}/") as page:
                assert title in page.read().decode()
