"""Serving the app with waitress."""

from __future__ import annotations

import logging
import os
from urllib.parse import quote

import waitress
from sqlalchemy import select
from sqlalchemy.exc import SQLAlchemyError

from annotation_app import tombstones
from annotation_app.account_links import first_admin_link, path_of
from annotation_app.accounts import admin_from_environment
from annotation_app.audit import COMMAND_LINE, note
from annotation_app.config import Config
from annotation_app.connections import Connections
from annotation_app.database import opened, reading, transaction
from annotation_app.factory import create_app
from annotation_app.installation import now
from annotation_app.models import Study
from annotation_app.readiness import Obstacle
from annotation_app.readiness import obstacles as found_obstacles
from annotation_app.retention import expire
from annotation_app.salt import installation_salt
from annotation_app.schema import migrate
from annotation_app.suggestions import warm_up

log = logging.getLogger(__name__)

LOOPBACK = ("127.0.0.1", "localhost", "::1")
WAIT_S = 1.0
"""How long to wait for something to come before the connections are looked after."""


def addresses(config: Config, base: str) -> list[tuple[str, str]]:
    """What there is to open, and where: each study, and once the making of the first admin."""
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


def _segments(config: Config) -> bool:
    """Whether people segment commands in some study."""
    with opened(config.database) as engine, reading(engine) as session:
        studies = session.scalars(select(Study).where(Study.closed_at.is_(None)))
        return any("segment" in study.config["tasks"] for study in studies)


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
    """What would stop people in the studies; :func:`addresses` tells how to make an admin."""
    with opened(config.database) as engine, reading(engine) as session:
        return found_obstacles(session, of_installation=False)


def note_on_this_machine(config: Config, action: str, about: str, **details: str) -> None:
    """Note in the audit trail what was done by a command that only reads the database."""
    try:
        with opened(config.database) as engine, transaction(engine) as session:
            note(session, COMMAND_LINE, action, about, **details)
    except (OSError, SQLAlchemyError):
        log.warning("the database can't be written to: the audit trail doesn't tell of this")


def serve(config: Config, *, host: str, port: int, threads: int) -> None:
    """Answer requests until interrupted.

    Raises
    ------
    OSError
        If the address can't be had.
    """
    if _segments(config):
        warm_up()
    logging.basicConfig()
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)
    connections = Connections()
    server = waitress.create_server(
        create_app(config),
        map=connections,
        host=host,
        port=port,
        threads=threads,
        ident=None,
        clear_untrusted_proxy_headers=not config.proxies,
        connection_limit=1000,
        max_request_body_size=2 * config.max_body_bytes,
    )
    try:
        while connections:
            connections.wait(WAIT_S)
    except (SystemExit, KeyboardInterrupt):
        server.task_dispatcher.shutdown()
