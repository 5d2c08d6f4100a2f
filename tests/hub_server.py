"""A small server with the Hugging Face Hub's protocol, for datasets that tests fetch and push."""

from __future__ import annotations

import base64
import hashlib
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import unquote, urlsplit

TOKEN = "hf_of_a_test"


def git_oid(content: bytes) -> str:
    return hashlib.sha1(b"blob %d\0" % len(content) + content).hexdigest()


@dataclass
class Repository:
    commits: list[dict[str, bytes]] = field(default_factory=lambda: [{".gitattributes": b""}])
    tags: dict[str, str] = field(default_factory=dict)
    is_private: bool = False

    @property
    def files(self) -> dict[str, bytes]:
        return self.commits[-1]

    @property
    def head(self) -> str:
        return hashlib.sha1(str(len(self.commits)).encode()).hexdigest()


@dataclass
class Hub:
    """The state of the server."""

    url: str = ""
    repositories: dict[str, Repository] = field(default_factory=dict)
    blobs: dict[str, bytes] = field(default_factory=dict)
    sent: list[str] = field(default_factory=list)
    """Digests of large files that were sent."""
    loses_next_answer: bool = False
    """True to make the next commit and hang up without an answer."""
    before_commit: Any = None
    """Called before the next commit, as if somebody else were quicker."""


@contextmanager
def running_hub() -> Iterator[Hub]:
    hub = Hub()

    class Handler(_Handler):
        state = hub

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    hub.url = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield hub
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class _Handler(BaseHTTPRequestHandler):
    state: Hub
    protocol_version = "HTTP/1.1"

    def log_message(self, *_: Any) -> None:
        pass

    def do_POST(self) -> None:
        self._content = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self._answer("POST")

    def do_PUT(self) -> None:
        content = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        digest = hashlib.sha256(content).hexdigest()
        self.state.blobs[digest] = content
        self.state.sent.append(digest)
        self._send(200, {})

    def do_GET(self) -> None:
        self._answer("GET")

    def do_HEAD(self) -> None:
        self._answer("HEAD")

    def do_DELETE(self) -> None:
        self._answer("DELETE")

    def _send(self, status: int, value: Any, **headers: str) -> None:
        content = value if isinstance(value, bytes) else json.dumps(value).encode()
        self.send_response(status)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Content-Type", "application/json")
        for name, text in headers.items():
            self.send_header(name.replace("_", "-"), text)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def _answer(self, method: str) -> None:
        parts = [unquote(part) for part in urlsplit(self.path).path.strip("/").split("/")]
        is_known = self.headers.get("Authorization") == f"Bearer {TOKEN}"
        if method in ("POST", "DELETE") and not is_known:
            self._send(401, {"error": "Invalid credentials"})
        elif parts[:3] == ["api", "repos", "create"]:
            told = json.loads(self._content)
            name = f"{told['organization']}/{told['name']}" if told.get("organization") else ""
            name = name or f"me/{told['name']}"
            is_new = name not in self.state.repositories
            repository = self.state.repositories.setdefault(name, Repository())
            if is_new:
                is_private = told.get("private") is True or told.get("visibility") == "private"
                repository.is_private = is_private
            status = 200 if is_new else 409
            self._send(status, {"url": f"{self.state.url}/datasets/{name}", "name": name})
        elif parts[0] == "api":
            self._of_repository(method, "/".join(parts[2:4]), parts[4:])
        elif parts[0] == "datasets" and parts[3:] == ["info", "lfs", "objects", "batch"]:
            self._large_files()
        elif parts[0] == "datasets" and parts[3] == "resolve":
            self._file("/".join(parts[1:3]), "/".join(parts[5:]))
        else:
            self._send(404, {"error": f"no {self.path}"})

    def _of_repository(self, method: str, name: str, rest: list[str]) -> None:
        repository = self.state.repositories.get(name)
        if repository is None or (repository.is_private and "Authorization" not in self.headers):
            self._send(
                404, {"error": "Repository not found"}, X_Error_Code="RepoNotFound",
                X_Error_Message="Repository not found",
            )  # fmt: skip
            return
        if not rest or rest[0] == "revision":
            names = [{"rfilename": file} for file in repository.files]
            self._send(200, {"id": name, "sha": repository.head, "siblings": names})
        elif rest[0] == "tree":
            self._send(200, [self._entry(*item) for item in repository.files.items()])
        elif rest[0] == "preupload":
            asked = json.loads(self._content)["files"]
            self._send(200, {"files": [self._mode(repository, f["path"]) for f in asked]})
        elif rest[0] == "commit":
            self._commit(repository, name)
        elif rest[0] == "refs":
            tags = [
                {"name": tag, "ref": f"refs/tags/{tag}", "targetCommit": commit}
                for tag, commit in repository.tags.items()
            ]
            self._send(200, {"branches": [], "converts": [], "tags": tags})
        elif rest[0] == "tag" and method == "POST":
            repository.tags[json.loads(self._content)["tag"]] = rest[1]
            self._send(200, {})
        elif rest[0] == "tag" and method == "DELETE":
            del repository.tags[rest[1]]
            self._send(200, {})
        else:
            self._send(404, {"error": f"no {self.path}"})

    def _entry(self, name: str, content: bytes) -> dict[str, Any]:
        entry = {"type": "file", "path": name, "size": len(content), "oid": git_oid(content)}
        if name.endswith(".mp4"):
            digest = hashlib.sha256(content).hexdigest()
            entry["lfs"] = {"oid": digest, "size": len(content), "pointerSize": 1}
        return entry

    def _mode(self, repository: Repository, path: str) -> dict[str, Any]:
        is_large, content = path.endswith(".mp4"), repository.files.get(path)
        oid = None
        if content is not None:
            oid = hashlib.sha256(content).hexdigest() if is_large else git_oid(content)
        mode = "lfs" if is_large else "regular"
        return {"path": path, "uploadMode": mode, "shouldIgnore": False, "oid": oid}

    def _large_files(self) -> None:
        objects = []
        for one in json.loads(self._content)["objects"]:
            actions = {"upload": {"href": f"{self.state.url}/lfs/{one['oid']}"}}
            is_there = one["oid"] in self.state.blobs
            objects.append(one | ({} if is_there else {"actions": actions}))
        self._send(200, {"transfer": "basic", "objects": objects})

    def _commit(self, repository: Repository, name: str) -> None:
        if self.state.before_commit is not None:
            self.state.before_commit()
            self.state.before_commit = None
        lines = [json.loads(line) for line in self._content.splitlines()]
        if lines[0]["value"].get("parentCommit") not in (None, repository.head):
            self._send(412, {"error": "A commit has happened since"})
            return
        files = dict(repository.files)
        for line in lines[1:]:
            value = line["value"]
            if line["key"] == "file":
                files[value["path"]] = base64.b64decode(value["content"])
            elif line["key"] == "lfsFile":
                files[value["path"]] = self.state.blobs[value["oid"]]
            else:
                del files[value["path"]]
        repository.commits.append(files)
        if self.state.loses_next_answer:
            self.state.loses_next_answer = False
            self.close_connection = True
            self.connection.close()
            return
        url = f"{self.state.url}/datasets/{name}/commit/{repository.head}"
        self._send(200, {"commitUrl": url, "commitOid": repository.head, "success": True})

    def _file(self, name: str, path: str) -> None:
        repository = self.state.repositories[name]
        content = repository.files[path]
        self._send(
            200, content, ETag=f'"{git_oid(content)}"', X_Repo_Commit=repository.head,
            X_Linked_Size=str(len(content)),
        )  # fmt: skip
