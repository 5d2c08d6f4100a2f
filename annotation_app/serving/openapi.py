"""The OpenAPI description of the JSON interface."""

from __future__ import annotations

from typing import Any

import flask
import msgspec
from flask import Blueprint, Response

from annotation_app.dashboard import dashboard_api as interface
from annotation_app.tasks.task_registry import task_names
from annotation_app.trying.try_pages import TryRequest
from annotation_app.web.api import REQUESTS
from corpus_tools import __version__

_JSON = "application/json"

blueprint = Blueprint("openapi", __name__, url_prefix="/api")


@blueprint.get("/openapi.json")
def openapi() -> Response:
    """The description of the interface."""
    return flask.jsonify(description())


def description() -> dict[str, Any]:
    """The whole description, version 3.1."""
    requests = {**REQUESTS, "try": TryRequest}
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
                "csrf": {"type": "apiKey", "in": "header", "name": "X-CSRFToken"},
            },
        },
        "security": [{"session": [], "csrf": []}],
        "paths": {
            "/api/session": {
                "get": {**_operation("session", "Who this is, and the CSRF token"), "security": []}
            },
            "/api/studies/{study}/tasks/{task}/lease": {
                "parameters": [_parameter("study"), _parameter("task", task_names())],
                "post": _operation("lease", "Take an item", refusals=(401, 404, 409)),
            },
            "/api/items/{item}": {
                "parameters": [_parameter("item")],
                "get": _operation("item", "An item, with its draft", refusals=(401, 404)),
            },
            "/api/items/{item}/answers": {
                "parameters": [_parameter("item")],
                "get": _operation("answers", "All answers of an item", refusals=(401, 403, 404)),
            },
            "/api/items/{item}/draft": {
                "parameters": [_parameter("item")],
                "put": _operation("draft", "Keep a draft", bodies["draft"]),
            },
            **{
                f"/api/items/{{item}}/{name}": {
                    "parameters": [_parameter("item")],
                    "post": _operation(name, summary, bodies[name]),
                }
                for name, summary in (
                    ("adjudicate", "Decide what the answer is"),
                    ("answer", "Answer an item"),
                    ("skip", "Give an item back"),
                    ("flag", "Tell that something is wrong with an item"),
                )
            },
            "/api/practice/{task}": {
                "parameters": [_parameter("task", task_names())],
                "post": _operation("practice", "Practice is done", refusals=(401, 404)),
            },
            "/api/try": {"post": _operation("try", "Try a command", bodies["try"])},
            "/api/try/{name}": {
                "parameters": [_parameter("name")],
                "get": _operation("tried", "How far an attempt is", refusals=(401, 403, 404)),
            },
            **interface.paths(),
        },
    }


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


def _parameter(name: str, values: tuple[str, ...] = ()) -> dict[str, Any]:
    schema: dict[str, Any] = {"type": "string", "minLength": 1}
    if values:
        schema["enum"] = list(values)
    return {"name": name, "in": "path", "required": True, "schema": schema}


def _operation(
    name: str,
    summary: str,
    body: dict[str, Any] | None = None,
    refusals: tuple[int, ...] = (401, 403, 404, 422),
) -> dict[str, Any]:
    reply = {"description": "Done", "content": {_JSON: {"schema": {"type": "object"}}}}
    error = {"$ref": "#/components/schemas/Error"}
    refused = {"description": "Refused, and why", "content": {_JSON: {"schema": error}}}
    operation: dict[str, Any] = {
        "operationId": name,
        "summary": summary,
        "responses": {
            "200": reply,
            **{str(status): refused for status in (400, 429, 503, *refusals)},
        },
    }
    if body is not None:
        operation["requestBody"] = {"required": True, "content": {_JSON: {"schema": body}}}
        operation["responses"]["413"] = refused
    return operation
