"""A study with the task of the example, done by two people: run beside the installed example."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from annotation_app.core.config import DATABASE_FILE, open_instance
from annotation_app.export.answer_tables import rows
from annotation_app.export.corpus_export import export_corpus
from annotation_app.serving.factory import create_app
from annotation_app.serving.openapi import description
from annotation_app.store.database import opened, reading
from annotation_app.study_setup.study_reading import read_study
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import COMMAND, Browser, described
from tests.annotation_app.conftest import set_up
from tests.annotation_app.rendered import render

OTHER = "Lift the tires that stand next to the truck."


def main(folder: Path, file: Path) -> dict[str, Any]:
    """What there was to see on the way from a video to a corpus."""
    study = read_study(file)
    config = open_instance(folder / "instance")
    database = config.instance / DATABASE_FILE
    set_up(database, study, render(folder / "videos"))
    with opened(database) as engine:
        app = create_app(config, engine)
        author, other = (Browser(app, study=study.name) for _ in range(2))
        for browser in (author, other):
            browser.practise("describe", "segment", "rate")
        leased = author.lease("describe", study.name).json
        author.answer(leased["item"], described())
        practice = other.client.get(f"/practice/paraphrase?study={study.name}")
        waits = other.lease("paraphrase", study.name).json["reason"]
        other.send("POST", "/api/practice/paraphrase", {})
        author.send("POST", "/api/practice/paraphrase", {})
        page = other.client.get(f"/s/{study.name}/paraphrase")
        script = other.client.get("/paraphrase/static/paraphrase.js")
        item = other.lease("paraphrase", study.name).json
        refused = other.answer(item["item"], {"text": COMMAND.upper(), "played_to_end": True})
        receipt = other.answer(item["item"], {"text": OTHER, "played_to_end": True})
        own = author.lease("paraphrase", study.name).json["reason"]
        to_segment = {
            other.lease("segment", study.name).json["payload"]["command"],
            author.lease("segment", study.name).json["payload"]["command"],
        }
        boss = Browser(app, "adjudicator", study.name)
        counts = boss.client.get(f"/api/dashboard/studies/{study.name}/corpus").json["data"]
        with reading(engine) as session:
            found = find_study(session, study.name)
            corpus = export_corpus(session, found)
            table = [(row["task"], row["command"], row["body"]) for row in rows(session, found)]
        return {
            "practice": practice.status_code,
            "waits": waits,
            "page": page.text,
            "policy": page.headers["Content-Security-Policy"],
            "script": script.text,
            "payload": item["payload"],
            "refused": [problem["message"] for problem in refused.json["problems"]],
            "receipt": receipt.json["state"],
            "own": own,
            "to segment": sorted(to_segment),
            "dashboard": boss.client.get(f"/dashboard/{study.name}").text,
            "counts": counts,
            "commands": [(c.text, c.video) for c in corpus.commands.values()],
            "table": table,
            "schema": description()["components"]["schemas"]["Collected"]["properties"],
        }


if __name__ == "__main__":
    json.dump(main(Path(sys.argv[1]), Path(sys.argv[2])), sys.stdout)
