"""Starting, filling and using our app, Potato and Label Studio."""

from __future__ import annotations

import http.client
import json
import sys
import time
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar
from urllib.parse import urlencode

from annotation_app.core.config import open_instance
from annotation_app.store.database import opened, transaction
from annotation_app.store.schema import migrate
from annotation_app.studies.study_file import RatedPair, StudyConfig, TaskConfig
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from tests.annotation_app.load import STUDY, add_workers, cookies
from tests.annotation_app.load_servers import CT
from tests.annotation_app.rendered import render

RATING = 4
TRIES = 30
"""Number of attempts before an error of the server's counts as one."""
TEXT = "Go to number {}."


@dataclass(frozen=True)
class Reply:
    """The status and content of a reply; what is shown of it is short."""

    status: int
    content: bytes

    def __repr__(self) -> str:
        return f"status {self.status}: {self.content[:80]!r}"

    @property
    def json(self) -> Any:
        return json.loads(self.content)


class Client:
    """A browser as far as servers are concerned: cookies, and a connection that is kept open."""

    def __init__(self, port: int) -> None:
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=120)
        self.cookies: dict[str, str] = {}
        self.headers: dict[str, str] = {}
        self.refused = 0

    def send(
        self,
        method: str,
        path: str,
        value: Any = None,
        *,
        form: bool = False,
        status: int | None = 200,
    ) -> Reply:
        """Send a value and return the reply, of this status if not None; retry after an error."""
        for _ in range(TRIES):
            reply = self.send_once(method, path, value, form=form)
            if reply.status < 500:
                break
            self.refused += 1
            time.sleep(0.5)
        assert status in (None, reply.status), reply
        return reply

    def send_once(self, method: str, path: str, value: Any = None, *, form: bool = False) -> Reply:
        """Send a value as JSON or as a form and return the reply."""
        headers = {**self.headers, "Cookie": "; ".join(f"{k}={v}" for k, v in self.cookies.items())}
        body = None
        if value is not None:
            body = urlencode(value) if form else json.dumps(value)
            kind = "x-www-form-urlencoded" if form else "json"
            headers["Content-Type"] = f"application/{kind}"
        try:
            self.connection.request(method, path, body, headers)
            reply = self.connection.getresponse()
        except http.client.HTTPException as error:
            self.connection.close()
            raise OSError(repr(error)) from error
        for line in reply.headers.get_all("Set-Cookie", []):
            name, _, text = line.partition(";")[0].partition("=")
            self.cookies[name] = text
        return Reply(reply.status, reply.read())


class Ours:
    """The app of this checkout, before SQLite."""

    name: ClassVar[str] = "corpus-tools-g3"
    WORKERS, EACH = 200, 40

    def command(self, folder: Path, port: int) -> list[str]:
        config = open_instance(folder / "instance", None)
        videos = rendered_videos(render(folder / "videos", ("one", "two")))
        pairs = tuple(RatedPair(TEXT.format(i), "one", "two") for i in range(2 * self.EACH))
        tasks = {"rate": TaskConfig(answers=self.WORKERS // 2, practice=False)}
        study = StudyConfig(watching="flagged", name=STUDY, title="Load", tasks=tasks, pairs=pairs)
        with opened(config.database) as engine:
            migrate(engine)
            with transaction(engine) as session:
                made = put_study(session, study, videos)
                people = add_workers(session, made.id, self.WORKERS)
        self.signed = cookies(config, people)
        serve = ["annotate", "serve", "--instance", str(config.instance), "--port", str(port)]
        return [sys.executable, *CT, *serve, "--database", str(config.database)]

    def surroundings(self, folder: Path) -> dict[str, str]:
        return {"PYTHONPATH": str(Path(__file__).resolve().parents[1])}

    def fill(self, port: int, workers: int, each: int) -> None:
        assert workers * each <= self.WORKERS * self.EACH, "too many for our study"

    def sign_in(self, client: Client, number: int) -> None:
        client.cookies["session"] = self.signed[number]
        client.headers["X-CSRFToken"] = client.send("GET", "/api/session").json["csrf"]

    def open(self, client: Client, number: int, turn: int) -> Any:
        return client.send("POST", f"/api/studies/{STUDY}/tasks/rate/lease", {}).json["item"]

    def answer(self, client: Client, item: Any) -> None:
        value = {"uuid": str(uuid.uuid4()), "body": {"rating": RATING}}
        client.send("POST", f"/api/items/{item}/answer", value)


@dataclass
class Potato:
    """Potato with its own server."""

    python: Path
    name: ClassVar[str] = "Potato"
    package: ClassVar[str] = "potato-annotation"
    ITEMS: ClassVar[int] = 400

    def command(self, folder: Path, port: int) -> list[str]:
        config = {
            "annotation_task_name": "Load",
            "task_dir": ".",
            "output_annotation_dir": "annotation_output",
            "output_annotation_format": "jsonl",
            "data_files": ["items.jsonl"],
            "item_properties": {"id_key": "id", "text_key": "text"},
            "require_password": False,
            "user_config": {"allow_all_users": True, "users": []},
            "max_annotations_per_user": 100,
            "annotation_schemes": [
                {
                    "annotation_type": "likert",
                    "name": "rating",
                    "description": "How well do they go together?",
                    "size": 5,
                    "min_label": "not at all",
                    "max_label": "well",
                }
            ],
        }
        items = [{"id": f"item{i}", "text": TEXT.format(i)} for i in range(self.ITEMS)]
        (folder / "items.jsonl").write_text("".join(f"{json.dumps(item)}\n" for item in items))
        (folder / "config.yaml").write_text(json.dumps(config))  # JSON is YAML
        return [str(self.python.parent / "potato"), "start", "config.yaml", "-p", str(port)]

    def surroundings(self, folder: Path) -> dict[str, str]:
        return {}

    def fill(self, port: int, workers: int, each: int) -> None:
        """Do nothing: its files hold everything."""

    def sign_in(self, client: Client, number: int) -> None:
        account = {"email": f"worker{number}", "pass": ""}
        client.send("POST", "/auth", account, form=True, status=None)
        client.send("GET", "/annotate")

    def open(self, client: Client, number: int, turn: int) -> Any:
        reply = client.send("POST", "/annotate", {"action": "next_instance"}, form=True)
        marker = b'id="instance_id" name="instance_id" type="hidden" value="'
        return reply.content.partition(marker)[2].partition(b'"')[0].decode()

    def answer(self, client: Client, item: Any) -> None:
        value = {"instance_id": item, "annotations": {f"rating:{RATING}": str(RATING)}}
        reply = client.send("POST", "/updateinstance", {**value, "span_annotations": []})
        assert reply.json["status"] == "success", reply


@dataclass
class LabelStudio:
    """Label Studio's community edition before SQLite."""

    python: Path
    name: ClassVar[str] = "Label Studio"
    package: ClassVar[str] = "label-studio"
    TOKEN: ClassVar[str] = uuid.uuid4().hex

    def command(self, folder: Path, port: int) -> list[str]:
        program = [str(self.python.parent / "label-studio"), "start", "--no-browser"]
        account = ["--username", "load@example.org", "--password", self.TOKEN]
        where = ["--port", str(port), "--internal-host", "127.0.0.1"]
        return [*program, *account, *where, "--user-token", self.TOKEN]

    def surroundings(self, folder: Path) -> dict[str, str]:
        return {
            "LABEL_STUDIO_BASE_DATA_DIR": str(folder / "data"),
            "LABEL_STUDIO_ENABLE_LEGACY_API_TOKEN": "true",
            "COLLECT_ANALYTICS": "false",
            "LATEST_VERSION_CHECK": "false",
        }

    def fill(self, port: int, workers: int, each: int) -> None:
        client = Client(port)
        self.sign_in(client, 0)
        view = (
            '<View><Text name="text" value="$text"/>'
            '<Rating name="rating" toName="text" maxRating="5"/></View>'
        )
        project = {"title": "Load", "label_config": view}
        project = client.send("POST", "/api/projects/", project, status=201).json["id"]
        items = [{"text": TEXT.format(i)} for i in range(workers * each)]
        client.send("POST", f"/api/projects/{project}/import", items, status=201)
        path = f"/api/tasks/?project={project}&page_size={len(items)}&fields=task_only"
        self.tasks = [task["id"] for task in client.send("GET", path).json["tasks"]]
        assert len(self.tasks) == len(items)
        self.workers = workers
        client.connection.close()

    def sign_in(self, client: Client, number: int) -> None:
        client.headers["Authorization"] = f"Token {self.TOKEN}"

    def open(self, client: Client, number: int, turn: int) -> Any:
        task = self.tasks[turn * self.workers + number]
        client.send("GET", f"/api/tasks/{task}/")
        return task

    def answer(self, client: Client, item: Any) -> None:
        rated = {"from_name": "rating", "to_name": "text", "type": "rating"}
        value = {"result": [{**rated, "value": {"rating": RATING}}]}
        client.send("POST", f"/api/tasks/{item}/annotations/", value, status=201)


Peer = Potato | LabelStudio
Program = Ours | Peer
PEERS: tuple[type[Peer], ...] = (Potato, LabelStudio)
