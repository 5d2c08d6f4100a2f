"""The OpenAPI description of the JSON interface."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import flask
import msgspec
from flask import Blueprint, Flask, Response

from annotation_app.dashboard import answers_api
from annotation_app.dashboard import dashboard_api as interface
from annotation_app.tasks.task_registry import task_names
from annotation_app.trying import try_pages
from annotation_app.trying.try_pages import TryRequest
from annotation_app.web import api
from annotation_app.web.api import REQUESTS
from corpus_tools import __version__

_JSON = "application/json"
REFUSALS = (400, 401, 403, 404, 429, 503)
"""Refusals of any request, and those of requests that change something."""

blueprint = Blueprint("openapi", __name__, url_prefix="/api")


@blueprint.get("/openapi.json")
def openapi() -> Response:
    """Return the description of the interface."""
    return flask.jsonify(description())


def description() -> dict[str, Any]:
    """Return the whole description, version 3.1, made of the routes and their docstrings."""
    requests = {**REQUESTS, **answers_api.REQUESTS, "try": TryRequest}
    schemas = msgspec.json.schema_components(
        requests.values(), ref_template="#/components/schemas/{name}"
    )
    bodies = dict(zip(requests, schemas[0], strict=True))
    return {
        "openapi": "3.1.0",
        "info": {"title": "Annotation app", "version": __version__},
        "components": {
            "schemas": {**schemas[1], **interface.schemas(), "Error": _ERROR},
            "securitySchemes": {
                "session": {"type": "apiKey", "in": "cookie", "name": "session"},
                "token": {"type": "http", "scheme": "bearer"},
                "csrf": {"type": "apiKey", "in": "header", "name": "X-CSRFToken"},
            },
        },
        "security": [{"session": [], "csrf": []}],
        "paths": _paths(bodies),
    }


def _paths(bodies: Mapping[str, Any]) -> dict[str, Any]:
    app = Flask(__name__)
    for one in (api, answers_api, try_pages, interface):
        app.register_blueprint(one.blueprint)
    found: dict[str, dict[str, Any]] = {}
    replies = interface.replies()
    for rule in app.url_map.iter_rules():
        if rule.rule.startswith("/api/"):
            path = re.sub(r"<(\w+?)(?:_name|_id)?>", r"{\1}", rule.rule)
            of, _, name = rule.endpoint.rstrip("_").partition(".")
            of_dashboard = of == interface.blueprint.name
            (method,) = (rule.methods or set()) - {"HEAD", "OPTIONS"}
            summary = str(app.view_functions[rule.endpoint].__doc__).partition(".")[0]
            operation = _operation(name, summary, method, bodies.get(name))
            if of_dashboard:
                operation["operationId"] = f"dashboard_{name}"
                operation["responses"]["200"]["content"] = {_JSON: {"schema": replies[name]}}
            found[path] = {method.lower(): operation}
            if names := re.findall(r"{(\w+)}", path):
                found[path]["parameters"] = [_parameter(one) for one in names]
            for asked in answers_api.QUERIES.get(name, ()):
                operation.setdefault("parameters", []).append(
                    {"name": asked, "in": "query", "schema": {"type": "string"}}
                )
    for name, paths in found.items():
        if name.startswith("/api/dashboard/") and "get" in paths:
            paths["get"]["security"] = interface.READERS
    found["/api/session"]["get"]["security"] = []
    return found


_ERROR = {
    "type": "object",
    "required": ["error"],
    "properties": {
        "error": {"type": "string"},
        "reason": {"type": "string"},
        "problems": {
            "type": "array",
            "items": {
                "type": "object",
                "required": ["field", "message"],
                "properties": {"field": {"type": "string"}, "message": {"type": "string"}},
            },
        },
    },
}


def _parameter(name: str) -> dict[str, Any]:
    schema: dict[str, Any] = {"type": "string", "minLength": 1}
    if name == "task":
        schema["enum"] = list(task_names())
    return {"name": name, "in": "path", "required": True, "schema": schema}


def _operation(name: str, summary: str, method: str, body: dict[str, Any] | None) -> dict[str, Any]:
    reply = {"description": "Done", "content": {_JSON: {"schema": {"type": "object"}}}}
    error = {"$ref": "#/components/schemas/Error"}
    refused = {"description": "Refused, and why", "content": {_JSON: {"schema": error}}}
    refusals = {*REFUSALS, *(() if method == "GET" else (409,)), *((413, 422) if body else ())}
    operation: dict[str, Any] = {
        "operationId": name,
        "summary": summary,
        "responses": {"200": reply, **{str(status): refused for status in sorted(refusals)}},
    }
    if body is not None:
        operation["requestBody"] = {"required": True, "content": {_JSON: {"schema": body}}}
    return operation
