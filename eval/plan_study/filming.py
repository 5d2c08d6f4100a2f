"""Videos of what a study's people rate: runs of plans, and logs of the test corpus."""

from __future__ import annotations

import os
from pathlib import Path

from corpus_tools.runtime.parallel import Workers
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.video.items import ContextItem, Item
from corpus_tools.video.manifest import MANIFEST, Settings
from corpus_tools.video.render_batch import produce_all
from eval.plan_study.study_pairs import Pair
from eval.plan_study.study_plans import run_corpus
from g3.errors import CorpusError

VIDEOS = "videos"
HOW = Settings(fps=15, quality="draft")


def film_all(
    folder: Path, test: str, pairs: list[Pair], on_progress: OnProgress = no_progress
) -> None:
    """Make the videos of all pairs that aren't there yet; a CorpusError if one can't be made."""
    wanted = {pair.video: pair for pair in pairs}
    items: list[Item] = [
        ContextItem(video, str(run_corpus(folder, video)) if pair.is_plan else test, video)
        for video, pair in sorted(wanted.items())
        if not (folder / VIDEOS / video / MANIFEST).exists()
    ]
    if not items:
        return
    (folder / VIDEOS).mkdir(exist_ok=True)
    workers = Workers(min(os.cpu_count() or 1, len(items)))
    before = len(wanted) - len(items)
    outcomes = produce_all(items, folder / VIDEOS, HOW, workers=workers, force=False)
    for number, outcome in enumerate(outcomes, before + 1):
        if outcome.problem:
            raise CorpusError(outcome.problem, where=f"the video {outcome.name}")
        on_progress(f"videos: {outcome.name}", number, len(wanted))
