"""Replies of a language model, kept on the disk so that no request is paid for twice.

A reply is kept under the digest of its whole request: endpoint, model, messages, schema, seed.
While a request is under way, a file marks it. If the program is killed then, it is unknown whether
the request was paid for: it is *in doubt*. It is sent again, and counted.
"""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import logging
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import msgspec

from g3.errors import CorpusError
from g3.storage.atomic_file import write_bytes

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

logger = logging.getLogger(__name__)

Origin = Literal["new", "kept"]


class Tokens(msgspec.Struct, frozen=True):
    """Numbers of tokens that an endpoint has counted."""

    prompt: int = 0
    completion: int = 0


class KeptReply(msgspec.Struct, frozen=True, kw_only=True):
    """A reply as it is kept.

    Parameters
    ----------
    request
        The request as sent, with the prompt, the model and the seed.
    model, fingerprint
        Model and fingerprint as reported by the endpoint.
    latency_s
        From sending the request that was answered to its answer.
    asked
        Time of the request, in UTC.
    tries
        Number of times that the request was sent.
    in_doubt
        Number of these that may have been paid for without an answer.
    """

    endpoint: str
    request: dict[str, Any]
    text: str
    model: str = ""
    fingerprint: str = ""
    tokens: Tokens = Tokens()
    latency_s: float = 0.0
    asked: str = ""
    tries: int = 1
    in_doubt: int = 0


class UnderWay(msgspec.Struct):
    """A request under way: number of times sent, and number of failures."""

    sent: int = 0
    unpaid: int = 0


@dataclass(frozen=True, slots=True)
class ReplyFolder:
    """A folder of kept replies."""

    path: Path

    def reply(self, key: str) -> KeptReply | None:
        """Return the reply to a request; None if there is no readable one."""
        path = self._reply(key)
        try:
            return msgspec.json.decode(path.read_bytes(), type=KeptReply)
        except FileNotFoundError:
            return None
        except (OSError, msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
            logger.warning("%s: the reply is damaged, so that it is asked for again", path)
            return None

    def keep(self, key: str, reply: KeptReply) -> None:
        """Keep a reply; from then on its request isn't sent again."""
        write_bytes(self._reply(key), msgspec.json.format(msgspec.json.encode(reply), indent=1))

    @contextlib.contextmanager
    def asking(self, key: str) -> Iterator[UnderWay]:
        """Lock a request: others wait until its reply is there, or its sender stops.

        The caller checks again for a reply after it gets the lock. A record written by :meth:`note`
        remains for the next process, should this program be killed.
        """
        marker = self._marker(key)
        marker.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(marker, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            if fcntl is not None:
                fcntl.flock(descriptor, fcntl.LOCK_EX)
            try:
                known = msgspec.json.decode(marker.read_bytes(), type=UnderWay)
            except (OSError, msgspec.MsgspecError):
                known = UnderWay()
            yield known
            if self._reply(key).exists():  # else others may be waiting for this very file
                marker.unlink(missing_ok=True)
        finally:
            os.close(descriptor)

    def note(self, key: str, known: UnderWay) -> None:
        """Record the state of a request, before it is sent and after it fails."""
        descriptor = os.open(self._marker(key), os.O_CREAT | os.O_WRONLY | os.O_TRUNC, 0o600)
        with os.fdopen(descriptor, "wb") as file:
            file.write(msgspec.json.encode(known))
            file.flush()
            os.fsync(file.fileno())

    def used(self, run: str, purpose: str, key: str, origin: Origin) -> None:
        """Note that a run has used a reply; processes may do so at the same time."""
        path = self.path / "runs" / f"{run}-{purpose}.log"
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab") as file:  # one short line, which the system adds in one piece
            file.write(f"{key} {origin}\n".encode())

    def used_by(self, run: str, purpose: str) -> dict[str, Origin]:
        """Return the requests that a run has used, with the origins of their replies."""
        found: dict[str, Origin] = {}
        path = self.path / "runs" / f"{run}-{purpose}.log"
        lines = path.read_text().split("\n") if path.exists() else []
        for key, origin in (line.split() for line in lines if line):
            found[key] = "new" if "new" in (origin, found.get(key)) else "kept"
        return found

    def _reply(self, key: str) -> Path:
        return self.path / key[:2] / f"{key}.json"

    def _marker(self, key: str) -> Path:
        return self.path / key[:2] / f"{key}.asked"


def open_folder(path: Path) -> ReplyFolder:
    """Open a folder for replies; create it if it is missing, and check that it is writable."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        if not os.access(path, os.W_OK):
            raise PermissionError(13, "permission denied")
    except OSError as error:
        raise CorpusError(
            f"replies can't be kept: {error.strerror}",
            where=str(path),
            fix="name another folder with --replies",
        ) from error
    return ReplyFolder(path)


def key_of(endpoint: str, request: dict[str, Any]) -> str:
    """Return the digest of a request to an endpoint."""
    content = msgspec.json.encode({"endpoint": endpoint, "request": request}, order="sorted")
    return hashlib.sha256(content).hexdigest()


def now() -> str:
    """Return the time in UTC, in ISO 8601."""
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="milliseconds")
