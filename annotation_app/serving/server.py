"""Serving the app with Granian."""

from __future__ import annotations

import asyncio
import atexit
import logging
import os
import signal
import socket
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, NoReturn
from urllib.parse import quote

from granian.constants import HTTPModes
from granian.http import HTTP1Settings
from granian.log import LogLevels
from granian.server.embed import Server
from sqlalchemy import select
from sqlalchemy.exc import SQLAlchemyError

from annotation_app.core.config import Config
from annotation_app.people.account_links import first_admin_link, path_of
from annotation_app.people.accounts import admin_from_environment
from annotation_app.privacy.retention import expire
from annotation_app.serving.factory import create_app
from annotation_app.serving.gateway import Gateway
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
CONNECTIONS = 3000
"""Largest number of connections."""
HEAD_S = 75.0
"""Longest time until the head of a request has come, from the connection or the last reply on, in
seconds: longer than proxies keep idle connections."""
FINISH_S = 7.0
"""Longest time for requests to finish at the end, in seconds."""
FILES = 4096
"""Number of files that may be open, if the system permits: connections, databases, videos."""


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
) -> NoReturn:
    """Answer requests on the sockets of :func:`bound` until Ctrl-C or a signal ends the process."""
    logging.basicConfig()
    with opened(config.database) as engine:
        app = create_app(config, engine)
        # After the app is made: before 3.11.8, Python fails where two threads parse code at once,
        # as Werkzeug does for its routes and spaCy for its settings (gh-106905).
        _warm_up(config)
        gateway = Gateway(app, threads=threads, body_bytes=2 * config.max_body_bytes)

        async def run() -> bool:
            end, most = _asked_to_end(), _connections()
            return await answer(gateway, bound, end, listening=listening, connections=most)

        loop = asyncio.new_event_loop()
        is_finished = loop.run_until_complete(run())
        with app.app_context():
            attempts().stop()
    if not is_finished:
        log.warning("requests that took longer than %.0f s were cut off", FINISH_S)
    # Python would wait for threads with such requests, and abort where one of Granian's still ends.
    atexit._run_exitfuncs()
    sys.stdout.flush()
    os._exit(0)


def _asked_to_end() -> asyncio.Event:
    """Return an event that is set at Ctrl-C or a signal to end; the next one ends the process.

    Also where a shell has started the process in the background, and so made it ignore Ctrl-C.
    """
    event, loop = asyncio.Event(), asyncio.get_running_loop()

    def ask(_number: int, _frame: Any) -> None:
        for number in SIGNALS:
            signal.signal(number, signal.SIG_DFL)
        loop.call_soon_threadsafe(event.set)

    for number in SIGNALS:
        signal.signal(number, ask)
    return event


async def answer(
    gateway: Gateway,
    bound: Sequence[socket.socket],
    end: asyncio.Event,
    *,
    listening: Callable[[], None],
    connections: int = CONNECTIONS,
    head_s: float = HEAD_S,
) -> bool:
    """Answer requests at the addresses of sockets until an event; return False if some are cut off.

    The sockets are closed.
    """

    def has_ended(_: object) -> None:
        gateway.listens.set()
        end.set()

    servers, running = [], []
    for one in bound:
        host, port = one.getsockname()[:2]
        servers.append(
            Server(
                gateway,
                host,
                port,
                backlog=connections,
                backpressure=connections,
                http=HTTPModes.http1,
                http1_settings=HTTP1Settings(header_read_timeout=int(1000 * head_s)),
                websockets=False,
                log_level=LogLevels.error,
                log_dictconfig={"loggers": {"_granian": {}}},
            )
        )
        one.close()
        gateway.listens.clear()
        running.append(asyncio.create_task(servers[-1].serve()))
        running[-1].add_done_callback(has_ended)
        await gateway.listens.wait()
    if not end.is_set():
        listening()
    await end.wait()
    for server in servers:
        server.stop()
    done, late = await asyncio.wait(running, timeout=FINISH_S)
    for task in done:
        task.result()
    return not late


def _connections() -> int:
    """Return the number of possible connections, after requesting as many files."""
    if resource is None:
        return CONNECTIONS
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < FILES and soft != resource.RLIM_INFINITY:
        soft = FILES if hard == resource.RLIM_INFINITY else min(hard, FILES)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return CONNECTIONS if soft >= FILES else max(1, soft // 2)
