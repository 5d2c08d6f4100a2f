"""The interface does what its description says, whatever is sent."""

from __future__ import annotations

import json
import os
from typing import Any

import pytest
import schemathesis
from flask import Flask
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from annotation_app.serving.openapi import description
from annotation_app.store.models import Role
from tests.annotation_app.browser import Browser

PHASES = (Phase.explicit, Phase.generate)
ROLES: tuple[Role, ...] = ("worker", "annotator", "adjudicator", "admin")
OPERATIONS = [
    (path, method)
    for path, operations in description()["paths"].items()
    for method in operations
    if method != "parameters"
]
CASES = int(os.environ.get("CT_FUZZ_CASES", "3000"))
"""How many requests are sent in all, by people of all roles: set it higher to look longer."""
EXAMPLES = -(-CASES // (len(OPERATIONS) * len(ROLES)))


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


@pytest.fixture(scope="module")
def schema() -> Any:
    return schemathesis.openapi.from_dict(description())


@pytest.mark.slow
@pytest.mark.parametrize(("path", "method"), OPERATIONS)
def test_nothing_makes_the_server_fail(app: Flask, schema: Any, path: str, method: str) -> None:
    people = [Browser(app, role) for role in ROLES]
    own_items = [person.take("describe")["item"] for person in people]
    operation = schema[path][method.upper()]
    strategy = operation.as_strategy() | operation.as_strategy(
        generation_mode=schemathesis.GenerationMode.NEGATIVE
    )

    @settings(
        max_examples=EXAMPLES, phases=PHASES, suppress_health_check=list(HealthCheck), deadline=None
    )
    @given(case=strategy, own=st.booleans())
    def check(case: Any, own: bool) -> None:
        names = {key: str(value) for key, value in (case.path_parameters or {}).items()}
        declared = {*case.operation.definition.raw["responses"], "404", "405", "308"}
        body = _encoded(case.body)
        for person, item in zip(people, own_items, strict=True):
            if own and "item" in names:
                names["item"] = item
            response = person.client.open(
                path.format(**names),
                method=method.upper(),
                data=body,
                headers={"X-CSRFToken": person.csrf, "Content-Type": "application/json"},
            )
            assert response.status_code < 500, response.text
            assert str(response.status_code) in declared

    check()


def _encoded(body: Any) -> bytes:
    if isinstance(body, bytes):
        return body
    try:
        return json.dumps(body).encode()
    except TypeError:
        return b""
