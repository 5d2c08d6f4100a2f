"""Addresses of the app's pages: within it, and for people who aren't in it yet.

A proxy may serve the app under a path of its own (``X-Forwarded-Prefix``). Its links begin with it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import flask

from annotation_app.store.installation import installation

if TYPE_CHECKING:
    from _typeshed.wsgi import StartResponse, WSGIApplication, WSGIEnvironment

_PREFIX = re.compile(r"(/[\w.~-]+)*")


def here(path: str) -> str:
    """Return a path of the app, such as ``/login``, as browsers know it."""
    return f"{flask.request.script_root}{path}"


def public(endpoint: str, **values: Any) -> str:
    """Return the whole address of a page, to be sent to people.

    It begins with the address that the app was started with (``--url``). Without one it begins as
    the request did.
    """
    address = installation().config.url
    if not address:
        return flask.url_for(endpoint, **values, _external=True)
    return address.rstrip("/") + flask.url_for(endpoint, **values).removeprefix(here(""))


def is_of_this_computer(address: str) -> bool:
    """Return whether nobody else's browser reaches an address."""
    host = urlsplit(address).hostname or ""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost" or host.endswith(".localhost")


def only_paths(app: WSGIApplication) -> WSGIApplication:
    """Return an app that ignores a proxy's path that is none, such as one to another site."""

    def called(environ: WSGIEnvironment, start_response: StartResponse) -> Iterable[bytes]:
        if not _PREFIX.fullmatch(str(environ.get("SCRIPT_NAME", "")).rstrip("/")):
            environ["SCRIPT_NAME"] = ""
        return app(environ, start_response)

    return called
