"""10 000 episodes of LeRobot, listed and imported: ``python -m benchmarks.many_episodes``.

Each lasts a second and has two cameras, state and action. Times are those of the processor.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from benchmarks.timing import best, row
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.study_input import study_input
from tests.lerobot_datasets import FPS, new_dataset


def main(episodes: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder, scratch = Path(name) / "dataset", Path(name) / "scratch"
        new_dataset(folder, language=False, lengths=(FPS,) * episodes, row_group_size=100 * FPS)
        listing, _ = best(lambda: list(open_dataset(folder).episodes()), clock=time.process_time)
        start = time.process_time()
        study_input(open_dataset(folder), scratch, scratch=scratch)
        row(
            f"a LeRobot dataset of {episodes:,} episodes: list; import, with curves",
            f"{listing:.2f} s; {time.process_time() - start:.1f} s",
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
