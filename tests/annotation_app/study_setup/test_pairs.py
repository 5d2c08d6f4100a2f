"""Pairs of commands and videos that a study's file names: from ``ct eval`` and back."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import msgspec
import pytest
from flask import Flask

from annotation_app.export.corpus_export import export_corpus
from annotation_app.store.database import reading, transaction
from annotation_app.studies.study_file import (
    RatedPair,
    StudyConfig,
    TaskConfig,
)
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from annotation_app.study_setup.study_reading import read_study
from annotation_app.work.handing_out import find_study
from corpus_tools.corpus.corpus_model import Corpus
from eval.plan_study.study_plans import Pair, PlanRecord, write_study
from eval.plan_study.whole_study import by_people
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, engine_of
from tests.annotation_app.rendered import VIDEOS

OWN = VIDEOS[2]
PAIRS = [
    Pair("Go there.", VIDEOS[0], OWN, "gold", "c1"),
    Pair("Go there.", VIDEOS[1], OWN, "random", "c1"),
    Pair("Go there.", OWN, OWN, "right", "c1"),
]
RECORDS = [
    PlanRecord("gold", "c1", OWN, "Go there.", 0.9, True, "", VIDEOS[0]),
    PlanRecord("random", "c1", OWN, "Go there.", 0.1, False, "it stands", VIDEOS[1]),
]


def test_people_rate_what_the_file_names(app: Flask, videos: Path, tmp_path: Path) -> None:
    written = read_study(write_study(tmp_path, PAIRS, seed=0))
    assert written.tasks["rate"].practice
    study = msgspec.structs.replace(written, tasks={"rate": TaskConfig(answers=5, practice=False)})
    for _ in range(2):  # the second time nothing is new
        with transaction(engine_of(app)) as session:
            put_study(session, study, rendered_videos(videos))
    for _ in range(2):
        rater = Browser(app, study="plans")
        for _ in PAIRS:
            page = rater.lease("rate", "plans").json
            assert page["payload"]["command"] == "Go there."
            assert rater.answer(page["item"], {"rating": 5, "watched_s": 1.0}).status_code == 200
        assert rater.lease("rate", "plans").status_code != 200
    with reading(engine_of(app)) as session:
        export_corpus(session, find_study(session, "plans")).save(tmp_path / "ratings")
    judgments = Corpus.load(tmp_path / "ratings").judgments
    assert Counter(j.shown_video for j in judgments) == dict.fromkeys(VIDEOS, 2)
    rows = {row.configuration: row for row in by_people(PAIRS, RECORDS, judgments, seed=0, draws=9)}
    assert set(rows) == {"random", "gold-top30", "gold-all", "right"}
    assert rows["gold-all"].share.value == 1.0
    assert (rows["right"].judgments, rows["right"].rated, rows["right"].n) == (2, 1, 1)


def test_a_pair_of_no_video_is_refused(app: Flask, videos: Path) -> None:
    study = StudyConfig(
        name="other",
        title="Other",
        watching="flagged",
        tasks={"rate": TaskConfig(practice=False)},
        pairs=(RatedPair("Go.", "nowhere", OWN),),
    )
    with (
        pytest.raises(FormatError, match="pair 1 names the video 'nowhere'"),
        transaction(engine_of(app)) as session,
    ):
        put_study(session, study, rendered_videos(videos))


def test_pairs_need_the_task(tmp_path: Path) -> None:
    pair = {"text": "Go.", "video": "a", "own_video": "b"}
    study = {"name": "x", "title": "X", "tasks": {"describe": {}}, "pairs": [pair]}
    file = tmp_path / "x.yaml"
    file.write_text(json.dumps(study))
    with pytest.raises(FormatError, match="no task to rate them in"):
        read_study(file)
