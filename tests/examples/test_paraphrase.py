"""A sixth task of the app, from another distribution: with it, and after it was taken away."""

from __future__ import annotations

import json
from typing import Any

import pytest

from annotation_app.core.config import DATABASE_FILE, open_instance
from annotation_app.export.corpus_export import export_corpus
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened, reading
from annotation_app.study_setup.readiness import obstacles
from annotation_app.study_setup.study_reading import read_study
from annotation_app.work.handing_out import find_study
from g3.errors import FormatError
from tests.annotation_app.browser import COMMAND, Browser
from tests.examples.installed import EXAMPLES, Installed, install
from tests.examples.paraphrase_round import OTHER

STUDY = EXAMPLES / "paraphrase" / "study.yaml"


@pytest.fixture(scope="module")
def paraphrase(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    return install("paraphrase", tmp_path_factory.mktemp("paraphrase"))


@pytest.fixture(scope="module")
def seen(paraphrase: Installed) -> dict[str, Any]:
    code = "import runpy; runpy.run_module('tests.examples.paraphrase_round', run_name='__main__')"
    done = paraphrase.python(code, str(paraphrase.folder), str(STUDY))
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_people_get_its_page(seen: dict[str, Any]) -> None:
    assert seen["practice"] == 200
    assert seen["waits"] == "no practice"
    assert '<textarea id="text"' in seen["page"]
    assert 'src="/paraphrase/static/paraphrase.js"' in seen["page"]
    assert "script-src 'self'" in seen["policy"]
    assert "begin(" in seen["script"]
    assert seen["payload"]["command"] == COMMAND
    assert seen["payload"]["duration_s"] == 1.0


def test_its_answers_are_checked_and_kept(seen: dict[str, Any]) -> None:
    assert seen["refused"] == ["These are the same words. Use others."]
    assert seen["receipt"] == "accepted"
    assert seen["table"][-1] == ["paraphrase", COMMAND, {"text": OTHER}]


def test_nobody_paraphrases_their_own_command(seen: dict[str, Any]) -> None:
    assert seen["own"] == "nothing to do" or seen["own"] == "done"


def test_a_paraphrase_is_a_command_like_others(seen: dict[str, Any]) -> None:
    assert seen["to segment"] == sorted((COMMAND, OTHER))
    (first, video), (second, same_video) = seen["commands"]
    assert ((first, second), video) == ((COMMAND, OTHER), same_video)


def test_the_dashboard_and_the_description_have_it(seen: dict[str, Any]) -> None:
    assert (seen["counts"]["commands"], seen["counts"]["paraphrases"]) == (1, 1)
    assert seen["schema"]["paraphrases"] == {"type": "integer"}
    assert "<dt>paraphrases</dt><dd>1</dd>" in seen["dashboard"]


def test_ct_reads_its_study(seen: dict[str, Any], paraphrase: Installed) -> None:
    done = paraphrase.ct("annotate", "check", str(STUDY), "--videos", "videos")
    assert "there is no task" not in done.stderr
    assert "nothing ever comes" not in done.stdout
    out = ("annotate", "export", "out", "--instance", "instance")
    assert "wrote out: 2 commands" in paraphrase.ct(*out).stdout


def test_without_the_example_its_studies_stay_readable(
    seen: dict[str, Any], paraphrase: Installed
) -> None:
    with pytest.raises(FormatError, match="there is no task"):
        read_study(STUDY)
    config = open_instance(paraphrase.folder / "instance")
    with opened(config.instance / DATABASE_FILE) as engine:
        app = create_app(config, engine)
        worker = Browser(app, study="other-words")
        worker.practise("describe")
        assert worker.client.get("/s/other-words").status_code == 200
        assert worker.lease("paraphrase", "other-words").status_code == 404
        assert worker.lease("describe", "other-words").status_code == 200
        boss = Browser(app, "adjudicator", "other-words")
        assert boss.client.get("/dashboard/other-words").status_code == 200
        with reading(engine) as session:
            whats = [obstacle.what for obstacle in obstacles(session, of_installation=False)]
            assert "the task paraphrase is not installed here" in whats
            commands = export_corpus(session, find_study(session, "other-words")).commands
            assert [command.text for command in commands.values()] == [COMMAND]
