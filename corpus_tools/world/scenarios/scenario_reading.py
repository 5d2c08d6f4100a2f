"""Finding scenarios and layouts by name, and reading them, with errors that name the line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

import msgspec

from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.scenarios.documents import (
    Document,
    Field,
    Problem,
    convert,
    read_document,
)
from corpus_tools.world.scenarios.scenario import Layout, Scenario
from corpus_tools.world.scenarios.scenario_files import (
    LAYOUTS,
    SCENARIOS,
    LayoutFile,
    ScenarioFile,
    Utterance,
)
from corpus_tools.world.scenarios.scenario_validation import layout_problems, scenario_problems
from corpus_tools.world.state.robot_script import ScriptStep
from g3.errors import FormatError, unknown_name

T = TypeVar("T")

DEFAULT = "warehouse"
"""The dataset where names are looked for if no other is given."""


def read_scenario(path: Path) -> Scenario:
    """Read a scenario and its layout, and check that it can be so."""
    return first_error(*scenario_of(read_document(path), path))


def read_layout(path: Path) -> Layout:
    """Read a layout and check that it can be so."""
    return first_error(*layout_of(read_document(path), path))


def all_errors(path: Path) -> list[FormatError]:
    """Return all errors of a scenario's file, its commands' form included."""
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
    """Return the scenario that a document describes, and its problems.

    Parameters
    ----------
    path
        Path of the document: its layout is looked for near it.

    Returns
    -------
    tuple
        The scenario is None if it is too wrong to be one.
    """
    fields, errors = _fields(document, ScenarioFile)
    if errors:
        return None, errors
    name, files = fields.pop("layout"), layout_files(path)
    if name not in files:
        problem = Problem(("layout",), *unknown_name("layout", name, sorted(files)))
        return None, [document.error(problem)]
    steps = fields.pop("script")
    script = tuple(ScriptStep(*entry) for step in steps for entry in step.items())
    scenario = Scenario(path.stem, layout=read_layout(files[name]), script=script, **fields)
    problems = scenario_problems(scenario)
    return scenario, [document.error(problem) for problem in problems]


def layout_of(document: Document, path: Path) -> tuple[Layout | None, list[FormatError]]:
    """Return the layout that a document describes, and its problems."""
    fields, errors = _fields(document, LayoutFile)
    if errors:
        return None, errors
    layout = Layout(path.stem, **fields)
    return layout, [document.error(problem) for problem in layout_problems(layout)]


def layout_files(path: Path) -> dict[str, Path]:
    """Return the layouts that a scenario's file can name: its dataset's, else the bundled ones'."""
    beside = path.resolve().parent.parent / LAYOUTS
    folders = [beside] if beside.is_dir() else [folder / LAYOUTS for folder in bundled().values()]
    return {file.stem: file for folder in folders for file in sorted(folder.glob("*.yaml"))}


def first_error(value: T | None, errors: list[FormatError]) -> T:
    """Raise the first error, if there is one; else the value is there."""
    if errors:
        raise errors[0]
    assert value is not None  # noqa: S101 - there is none only where there is an error
    return value


def _fields(
    document: Document, file_type: type[msgspec.Struct]
) -> tuple[dict[str, Any], list[FormatError]]:
    """Return the fields of a file in the types of its form but for commands, and the problems.

    Where something is wrong, some of the fields may be of no use.
    """
    given, problems = document.value, list[Problem]()
    if not isinstance(given, dict):
        problem = Problem((), "the file holds no fields", "see docs/scenarios.md for the form")
        return {}, [document.error(problem)]

    def converted(value: Any, kind: Any, field: Field) -> Any:
        result = convert(value, kind, field)
        if isinstance(result, Problem):
            problems.append(result)
            return None
        return result

    problems += _name_problems(given, file_type)
    values: dict[str, Any] = {}
    for form in msgspec.structs.fields(file_type):
        name = form.name
        if name == "commands":
            continue
        if name not in given:
            values[name] = {} if form.default is msgspec.NODEFAULT else form.default
        elif get_origin(form.type) is dict:
            _, kind = get_args(form.type)
            items = converted(given[name], dict[str, Any], (name,)) or {}
            values[name] = {key: converted(item, kind, (name, key)) for key, item in items.items()}
        else:
            values[name] = converted(given[name], form.type, (name,))
    return values, [document.error(problem) for problem in problems]


def _name_problems(given: Mapping[str, Any], file_type: type[msgspec.Struct]) -> Iterator[Problem]:
    """Yield the problems of missing fields, and of unknown ones."""
    fields = msgspec.structs.fields(file_type)
    for field in fields:
        if field.required and field.name not in given:
            yield Problem((), f"the field {field.name!r} is missing", "add it")
    names = [field.name for field in fields]
    for name in given:
        if name in names:
            continue
        _, fix = unknown_name("field", name, names)
        yield Problem((name,), "there is no such field", fix)


def dataset_folder(name_or_path: str | Path) -> Path:
    """Return a dataset's folder: a folder as it is, or a bundled one by name; or FormatError."""
    path = Path(name_or_path)
    if path.is_dir():
        return path
    datasets = bundled()
    if str(name_or_path) not in datasets:
        raise FormatError.unknown("folder or bundled dataset", str(name_or_path), datasets)
    return datasets[str(name_or_path)]


def scenario_files(dataset: Path) -> dict[str, Path]:
    """Return the files of a dataset's scenarios by name, in the order of the names."""
    return {path.stem: path for path in sorted((dataset / SCENARIOS).glob("*.yaml"))}


def scenario_file(name_or_path: str, dataset: Path) -> Path:
    """Return a scenario's file: a file as it is, or one of a dataset by name; or FormatError."""
    path = Path(name_or_path)
    if path.is_file():
        return path
    files = scenario_files(dataset)
    if name_or_path not in files:
        raise FormatError.unknown(
            "file or scenario", name_or_path, files, more="ct scenarios list shows them"
        )
    return files[name_or_path]


def read_layouts(dataset: Path, names: Iterable[str] = ()) -> dict[str, Layout]:
    """Read a dataset's layouts by name; all of them if no names are given.

    FormatError if one isn't there, or something in it is wrong.
    """
    files = {path.stem: path for path in sorted((dataset / LAYOUTS).glob("*.yaml"))}
    for name in names:
        if name not in files:
            raise FormatError.unknown("layout", name, files, where=str(dataset))
    return {name: read_layout(files[name]) for name in (sorted(names) or files)}
