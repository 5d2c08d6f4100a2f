"""The interface does what its description says, whatever is sent."""

from __future__ import annotations

import json
from typing import Any

import pytest
import schemathesis
from flask import Flask
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from annotation_app.openapi import description
from tests.annotation_app.browser import Browser

PHASES = (Phase.explicit, Phase.generate)


def test_every_route_is_described(app: Flask) -> None:
    described = description()["paths"]
    served = {
        rule.rule.replace("<", "{").replace(">", "}").replace("_name}", "}").replace("_id}", "}")
        for rule in app.url_map.iter_rules()
        if rule.rule.startswith("/api/")
    }
    assert served - {"/api/openapi.json"} == set(described)


def test_the_description_is_well_formed() -> None:
    for schema in description()["components"]["schemas"].values():
        Draft202012Validator.check_schema(schema)


@pytest.mark.parametrize("role", ["worker", "adjudicator"])
@pytest.mark.parametrize(
    ("path", "method"),
    [
        (path, method)
        for path, operations in description()["paths"].items()
        for method in operations
        if method != "parameters"
    ],
)
def test_nothing_makes_the_server_fail(app: Flask, path: str, method: str, role: Any) -> None:
    person = Browser(app, role)
    item = person.take("describe")["item"]
    schema = schemathesis.openapi.from_wsgi("/api/openapi.json", app)
    strategy = schema[path][method.upper()].as_strategy() | schema[path][
        method.upper()
    ].as_strategy(generation_mode=schemathesis.GenerationMode.NEGATIVE)

    @settings(
        max_examples=25, phases=PHASES, suppress_health_check=list(HealthCheck), deadline=None
    )
    @given(case=strategy, own=st.booleans())
    def check(case: Any, own: bool) -> None:
        names = dict(case.path_parameters or {})
        if own and "item" in names:
            names["item"] = item
        body = case.body
        response = person.client.open(
            case.operation.schema.get_full_path(path).format(
                **{key: str(value) for key, value in names.items()}
            ),
            method=method.upper(),
            data=_encoded(body),
            headers={"X-CSRFToken": person.csrf, "Content-Type": "application/json"},
        )
        assert response.status_code < 500, response.text
        declared = case.operation.definition.raw["responses"]
        assert str(response.status_code) in {*declared, "404", "405", "308"}

    check()


def _encoded(body: Any) -> bytes:
    if isinstance(body, bytes):
        return body
    try:
        return json.dumps(body).encode()
    except TypeError:
        return b""
