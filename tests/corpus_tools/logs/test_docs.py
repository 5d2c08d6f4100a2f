"""The page on logs tells what is so."""

from __future__ import annotations

import re
from pathlib import Path

from corpus_tools.logs.channels import CHANNELS
from corpus_tools.logs.log_writing import write_log
from tests.processes import python

PAGE = (Path(__file__).parents[3] / "docs" / "logs.md").read_text(encoding="utf-8")


def test_the_example_reads_a_log(tmp_path, driving):
    write_log(driving, tmp_path / "log.mcap", name="pick_up_tires", metadata={})
    (script,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    assert python("-c", script, cwd=tmp_path).stdout.splitlines() == [
        "pick_up_tires 2 s",
        "0.5 to 2 s: pick_up {'object': 'tires'}",
        "[-1.  0.  0.]",
    ]


def test_the_page_lists_all_channels():
    listed = dict(re.findall(r"^\| `(/\w+)` \| `([\w.]+)` \|", PAGE, flags=re.MULTILINE))
    assert listed == {topic: channel.schema for topic, channel in CHANNELS.items()}
