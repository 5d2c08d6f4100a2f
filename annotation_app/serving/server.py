"""Serving the app with waitress."""

from __future__ import annotations

import logging
import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any
from urllib.parse import quote

import waitress
from sqlalchemy import select
from sqlalchemy.exc import SQLAlchemyError

from annotation_app.core.config import Config
from annotation_app.people.account_links import first_admin_link, path_of
from annotation_app.people.accounts import admin_from_environment
from annotation_app.privacy.retention import expire
from annotation_app.serving.connections import CONNECTIONS, Connections, Room
from annotation_app.serving.factory import create_app
from annotation_app.store import tombstones
from annotation_app.store.audit import COMMAND_LINE, note
from annotation_app.store.database import OnlyReadError, opened, reading, transaction
from annotation_app.store.installation import now
from annotation_app.store.models import Study
from annotation_app.store.salt import installation_salt
from annotation_app.store.schema import migrate
from annotation_app.study_setup.readiness import Obstacle
from annotation_app.study_setup.readiness import obstacles as found_obstacles
from annotation_app.tasks.task_registry import tasks
from annotation_app.trying.attempt_queue import attempts
from g3.errors import FormatError

try:
    import resource
except ImportError:  # there is none on Windows
    resource = None  # type: ignore[assignment]

log = logging.getLogger(__name__)

LOOPBACK = ("127.0.0.1", "localhost", "::1")
SIGNALS = (signal.SIGINT, signal.SIGTERM)
WAIT_S = 1.0
"""Longest wait for data before the connections are checked, in seconds."""
FINISH_S = 7.0
"""Longest time for requests to finish at the end, in seconds."""
STOP_S = 1.0
"""Longest time for threads to stop at the end, when at most one has work left, in seconds."""
FILES = 4096
"""Number of files that may be open, if the system permits: connections, databases, videos."""
MARGIN = 100
"""Number of connections beyond the limit that are accepted while all are being answered."""
NEVER_S = 10**9
"""Waitress closes silent connections by the clock, which may jump; `Room` does it instead."""


def addresses(config: Config, base: str) -> list[tuple[str, str]]:
    """Return the addresses to open: each study, and once the page for the first admin."""
    with opened(config.database) as engine:
        with reading(engine) as session:
            studies = session.scalars(select(Study).order_by(Study.created_at)).all()
        with transaction(engine) as session:
            token = first_admin_link(session)
    found = [(f"study {study.name}", f"{base}/s/{quote(study.name)}") for study in studies]
    if token is not None:
        found.append(("make the first admin, once, within a day", f"{base}{path_of(token)}"))
    else:
        found.append(("sign in", f"{base}/login"))
    return found


def _warm_up(config: Config) -> None:
    """Get the tasks of open studies ready, in the background."""
    with opened(config.database) as engine, reading(engine) as session:
        studies = session.scalars(select(Study).where(Study.closed_at.is_(None)))
        names = {name for study in studies for name in study.config["tasks"]}
    for task in tasks():
        if task.warm_up is not None and task.name in names:
            task.warm_up()


def prepare(config: Config) -> None:
    """Bring the database and the key file up to date, and erase what is due to be."""
    with opened(config.database) as engine:
        migrate(engine)
        installation_salt(engine, config)
        expire(engine, now=now())
        tombstones.keep(engine, config.instance)


def make_first_admin(config: Config) -> None:
    """Make the first admin, if the environment names one and there is none."""
    with opened(config.database) as engine, transaction(engine) as session:
        admin_from_environment(session, os.environ)


def obstacles(config: Config) -> list[Obstacle]:
    """Return obstacles for people in the studies; :func:`addresses` shows how to make an admin."""
    with opened(config.database) as engine, reading(engine) as session:
        return found_obstacles(session, of_installation=False)


def note_on_this_machine(config: Config, action: str, about: str, **details: str) -> None:
    """Note in the audit trail what was done by a command that only reads the database."""
    try:
        with opened(config.database) as engine, transaction(engine) as session:
            note(session, COMMAND_LINE, action, about, **details)
    except (OSError, SQLAlchemyError, OnlyReadError):
        log.warning("the database can't be written to: this is not in the audit trail")


@contextmanager
def bound(host: str, port: int) -> Iterator[list[socket.socket]]:
    """Take an address, or several of a name, at a port, or any if it is 0; nobody can connect yet.

    A FormatError says that the address can't be had.
    """
    flags, stream = socket.AI_PASSIVE, socket.SOCK_STREAM
    with ExitStack() as opened:
        made = []
        with _named(host, port):
            for found in dict.fromkeys(socket.getaddrinfo(host, port, type=stream, flags=flags)):
                family, kind, protocol, _, address = found
                made.append(opened.enter_context(socket.socket(family, kind, protocol)))
                made[-1].setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                if family == socket.AF_INET6:
                    made[-1].setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
                made[-1].bind((address[0], port, *address[2:]))
                port = port_of(made)
        yield made


def port_of(bound: Sequence[socket.socket]) -> int:
    """Return the port that was taken."""
    return int(bound[0].getsockname()[1])


@contextmanager
def _named(host: str, port: int) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise FormatError(
            f"nobody can be served there: {error.strerror}",
            where=f"{host}:{port}",
            fix="name another --port or --host, or end the program that uses it",
        ) from error


def serve(
    config: Config,
    bound: Sequence[socket.socket],
    *,
    threads: int,
    listening: Callable[[], None] = lambda: None,
) -> None:
    """Answer requests on the sockets of :func:`bound` until Ctrl-C or a signal ends the server.

    A second signal ends it at once.
    """
    logging.basicConfig()
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)
    room = Room(_most_connections())
    connections = Connections(room)
    with opened(config.database) as engine, asked_to_end(connections.ring) as end:
        app = create_app(config, engine)
        with _named(str(bound[0].getsockname()[0]), port_of(bound)):
            server = waitress.create_server(
                app,
                map=connections,
                sockets=list(bound),
                threads=threads,
                ident=None,
                clear_untrusted_proxy_headers=not config.proxies,
                connection_limit=room.most + MARGIN,
                channel_timeout=NEVER_S,
                max_request_body_size=2 * config.max_body_bytes,
            )
        # After the app is made: before 3.11.8, Python fails where two threads parse code at once,
        # as Werkzeug does for its routes and spaCy for its settings (gh-106905).
        _warm_up(config)
        listening()
        with app.app_context():
            if config.open_trying or attempts().folder.is_dir():  # others try none, or seldom
                attempts().warm_up()
            while not end.is_set():
                connections.wait(WAIT_S)
        if not connections.finish(FINISH_S):
            log.warning("requests that took longer than %.0f s were cut off", FINISH_S)
        server.task_dispatcher.shutdown(timeout=STOP_S)
        with app.app_context():
            attempts().stop()


@contextmanager
def asked_to_end(ring: Callable[[], None]) -> Iterator[threading.Event]:
    """Yield an event that is set, and rings, at Ctrl-C or a signal to end.

    Also where a shell has started the process in the background, and so made it ignore Ctrl-C.
    """
    event = threading.Event()
    if threading.current_thread() is not threading.main_thread():  # others get no signals
        yield event
        return

    def ask(_number: int, _frame: Any) -> None:
        for number in SIGNALS:
            signal.signal(number, signal.SIG_DFL)
        event.set()
        ring()

    before = {number: signal.signal(number, ask) for number in SIGNALS}
    try:
        yield event
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _most_connections() -> int:
    """Return the number of possible connections, after requesting as many files."""
    if resource is None:
        return CONNECTIONS
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < FILES and soft != resource.RLIM_INFINITY:
        soft = FILES if hard == resource.RLIM_INFINITY else min(hard, FILES)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return CONNECTIONS if soft >= FILES else max(1, min(CONNECTIONS, soft // 2))
