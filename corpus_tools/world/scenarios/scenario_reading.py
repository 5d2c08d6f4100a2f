"""Reading scenarios and layouts, with errors that name the line."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

import msgspec

from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.scenarios.documents import (
    Document,
    Field,
    Problem,
    convert,
    read_document,
)
from corpus_tools.world.scenarios.scenario import (
    Bounds,
    Layout,
    Point,
    Region,
    Robot,
    Scenario,
    SiteName,
    Thing,
)
from corpus_tools.world.scenarios.scenario_files import (
    LAYOUTS,
    LayoutFile,
    ScenarioFile,
    Steps,
    Utterance,
)
from corpus_tools.world.scenarios.scenario_validation import layout_problems, scenario_problems
from corpus_tools.world.state.robot_script import ScriptStep
from g3.errors import FormatError, unknown_name

T = TypeVar("T")


def read_scenario(path: Path) -> Scenario:
    """Read a scenario and its layout, and check that it can be so.

    Raises
    ------
    FormatError
        The first problem, at its line.
    """
    scenario, errors = scenario_of(read_document(path), path)
    return first_error(scenario, errors)


def read_layout(path: Path) -> Layout:
    """Read a layout and check that it can be so.

    Raises
    ------
    FormatError
        The first problem, at its line.
    """
    layout, errors = layout_of(read_document(path), path)
    return first_error(layout, errors)


def all_errors(path: Path) -> list[FormatError]:
    """Everything that is wrong with a scenario's file, its commands' form included."""
    try:
        document = read_document(path)
        _, errors = scenario_of(document, path)
    except FormatError as error:
        return [error]
    commands = document.value.get("commands") if isinstance(document.value, dict) else None
    forms = [
        convert(command, Utterance, ("commands", i))
        for i, command in enumerate(commands if isinstance(commands, list) else ())
    ]
    return errors + [document.error(form) for form in forms if isinstance(form, Problem)]


def scenario_of(document: Document, path: Path) -> tuple[Scenario | None, list[FormatError]]:
    """The scenario that a document describes, and what is wrong with it.

    Parameters
    ----------
    path
        Where the document is: its layout is looked for near it.

    Returns
    -------
    tuple
        The scenario is None if it is too wrong to be one.

    Raises
    ------
    FormatError
        If its layout can't be read.
    """
    form = _Form(document, ScenarioFile)
    title, name = form.value("title", str), form.value("layout", str)
    robot = form.value("robot", Robot)
    steps = form.value("script", Steps)
    objects, places = form.values("objects", Thing), form.values("places", Region)
    if form.problems:
        return None, form.errors()
    files = layout_files(path)
    if name not in files:
        problem = Problem(("layout",), *unknown_name("layout", name, sorted(files)))
        return None, [document.error(problem)]
    script = tuple(ScriptStep(*entry) for step in steps for entry in step.items())
    layout = read_layout(files[name])
    scenario = Scenario(path.stem, title, layout, objects, places, robot, script)
    problems = scenario_problems(scenario)
    return scenario, [document.error(problem) for problem in problems]


def layout_of(document: Document, path: Path) -> tuple[Layout | None, list[FormatError]]:
    """The layout that a document describes, and what is wrong with it."""
    form = _Form(document, LayoutFile)
    title, bounds = form.value("title", str), form.value("bounds", Bounds)
    at, yaw_deg = form.value("at", Point, (0.0, 0.0)), form.value("yaw_deg", float, 0.0)
    objects, places = form.values("objects", Thing), form.values("places", Region)
    site = form.value("site", SiteName, "yard")
    if form.problems:
        return None, form.errors()
    layout = Layout(path.stem, title, at, yaw_deg, bounds, objects, places, site)
    return layout, [document.error(problem) for problem in layout_problems(layout)]


def layout_files(path: Path) -> dict[str, Path]:
    """The layouts that a scenario's file can name: its dataset's, else the bundled ones'."""
    own = path.resolve().parent.parent / LAYOUTS
    folders = [own] if own.is_dir() else [folder / LAYOUTS for folder in bundled().values()]
    return {file.stem: file for folder in folders for file in sorted(folder.glob("*.yaml"))}


def first_error(value: T | None, errors: list[FormatError]) -> T:
    """Raise the first error, if there is one; else the value is there."""
    if errors:
        raise errors[0]
    assert value is not None  # noqa: S101 - there is none only where there is an error
    return value


class _Form:
    """Takes a document apart, and collects what hasn't the form it should have."""

    def __init__(self, document: Document, file_type: type[msgspec.Struct]) -> None:
        self.document = document
        self.problems: list[Problem] = []
        self.fields: dict[str, Any] = {}
        if not isinstance(document.value, dict):
            self.note((), "the file holds no fields", "see docs/scenarios.md for the form")
            return
        self.fields = document.value
        for field in msgspec.structs.fields(file_type):
            if field.required and field.name not in self.fields:
                self.note((), f"the field {field.name!r} is missing", "add it")
        for name in self.fields:
            if name not in file_type.__struct_fields__:
                known = ", ".join(file_type.__struct_fields__)
                self.note((name,), "there is no such field", f"the fields are: {known}")

    def note(self, field: Field, what: str, fix: str) -> None:
        self.problems.append(Problem(field, what, fix))

    def errors(self) -> list[FormatError]:
        return [self.document.error(problem) for problem in self.problems]

    def value(self, name: str, record_type: Any, default: Any = None) -> Any:
        """A field's value; the default where there is no right one."""
        if name not in self.fields:
            return default
        return self.convert(self.fields[name], record_type, (name,), default)

    def values(self, name: str, record_type: type[T]) -> dict[str, T]:
        """A field's entries by their names."""
        given = self.value(name, dict[str, Any], {})
        found = {key: self.convert(item, record_type, (name, key)) for key, item in given.items()}
        return {key: item for key, item in found.items() if item is not None}

    def convert(self, value: Any, record_type: Any, field: Field, default: Any = None) -> Any:
        found = convert(value, record_type, field)
        if isinstance(found, Problem):
            self.problems.append(found)
            return default
        return found
