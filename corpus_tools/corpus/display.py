"""Corpora, commands, annotations and contexts as text for people, and as records for programs."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from corpus_tools.corpus.corpus_entries import belongs_to
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_statistics import PAPER, Statistics
from corpus_tools.corpus.corpus_tables import Content, as_lists, encode
from corpus_tools.corpus.task_outcomes import is_drive, outcomes_of
from corpus_tools.runtime.text_tables import WIDTH, columns
from g3.annotation import Annotation, Command, TaskOutcome
from g3.errors import CorpusError
from g3.groundings import Context, Grounding, PhysicalObject, Place, Trajectory
from g3.sdc.clauses import all_words, breadth_first
from g3.sdc.sdc_notation import format_brackets

EXAMPLE_WIDTH = 70
LABELS = {True: "right", False: "wrong", None: "-"}


def show(corpus: Corpus, name: str) -> str:
    """Describe the command, annotation, context or outcome with an id; CorpusError for none."""
    matches = [
        *(_command(corpus, command) for key, command in corpus.commands.items() if key == name),
        *(_annotation(a) for a in corpus.annotations if a.id == name),
        *(_context(corpus, context) for key, context in corpus.contexts.items() if key == name),
        *(f"outcome {o.id}\n  {_outcome(corpus, o)}" for o in corpus.outcomes if o.id == name),
    ]
    if not matches:
        raise CorpusError(
            f"no command, annotation, context or outcome has the id {name!r}",
            where=corpus.name,
            fix="`ct corpus show` without an id lists the scenarios and shows what ids look like",
        )
    return "\n\n".join(matches)


def overview(corpus: Corpus) -> str:
    """Describe a corpus: where it is from, and its scenarios with an example each."""
    rows = [tuple(map(str, row.values())) for row in _scenarios(corpus)]
    lines = [
        corpus.name,
        *textwrap.wrap(f"  source   {corpus.source}", WIDTH, subsequent_indent=" " * 11),
        f"  licence  {corpus.licence}",
        f"  hash     {corpus.hash}",
        f"  {len(corpus.contexts)} contexts, {len(corpus.commands)} commands, "
        f"{len(corpus.annotations)} annotations, {len(corpus.judgments)} judgments, "
        f"{len(corpus.outcomes)} outcomes",
        "",
        *columns(
            [("scenario", "typed", "annotated", "id", "a command, annotated if any is"), *rows]
        ),
    ]
    if corpus.annotations:
        example = corpus.annotations[0]
        ids = f"Ids: {example.command.id} (command), {example.id}, {example.context.id}"
        lines += ["", *textwrap.wrap(ids, WIDTH, subsequent_indent="     ")]
    return "\n".join(lines)


def overview_record(corpus: Corpus) -> Mapping[str, object]:
    """Return the content of :func:`overview` for programs."""
    return {
        "name": corpus.name,
        "source": corpus.source,
        "licence": corpus.licence,
        "hash": corpus.hash,
        "contexts": len(corpus.contexts),
        "commands": len(corpus.commands),
        "annotations": len(corpus.annotations),
        "judgments": len(corpus.judgments),
        "outcomes": len(corpus.outcomes),
        "scenarios": _scenarios(corpus),
    }


def _scenarios(corpus: Corpus) -> list[dict[str, object]]:
    typed = Counter(command.scenario for command in corpus.commands.values())
    first: dict[str, dict[str, Command]] = {}
    for command in corpus.commands.values():
        first.setdefault(command.scenario, {command.id: command})
    annotated: dict[str, dict[str, Command]] = {}
    for annotation in corpus.annotations:
        command = annotation.command
        annotated.setdefault(command.scenario, {})[command.id] = command
    rows = []
    for scenario, count in sorted(typed.items()):
        commands = annotated.get(scenario, {})
        name, text = _example(commands or first[scenario])
        row = {"typed": count, "annotated": len(commands), "id": name, "command": text}
        rows.append({"scenario": scenario, **row})
    return rows


def _example(commands: Mapping[str, Command]) -> tuple[str, str]:
    """Return the id and the text of the first command; empty if there is none."""
    for command in commands.values():
        text = " ".join(command.text.split())
        return command.id, textwrap.shorten(text, EXAMPLE_WIDTH, placeholder=" ...")
    return "", ""


def statistics_table(statistics: Statistics) -> str:
    """Format the counts, with the paper's beside them unless the commands are authored."""
    s = statistics
    rows: list[tuple[str, ...]] = [
        ("", "corpus", "paper"),
        ("videos", str(s.videos), f"{PAPER['videos']:g}"),
        ("subjects", str(s.subjects), f"{PAPER['subjects']:g}"),
        ("commands annotated", str(s.commands), ""),
        ("commands typed", str(s.commands_typed), ""),
        (
            "commands per video",
            f"{s.commands_per_video:.1f}",
            f"{PAPER['commands_per_video']:g}",
        ),
        ("scenarios", str(len(s.scenarios)), ""),
        ("contexts", str(s.contexts), ""),
        ("SDCs, implicit figures included", str(s.sdcs), ""),
        *((f"  {name}", str(count), "") for name, count in s.sdcs_by_type.items()),
        ("  implicit figures (OBJECT)", str(s.implicit), ""),
        *((f"annotations, {name}", str(n), "") for name, n in s.annotations.items()),
        *(
            (f"examples, {name}", f"{e.true} right, {e.false} wrong", "")
            for name, e in s.examples_by_source.items()
        ),
        ("judgments", str(s.judgments), ""),
        ("  of a command with its video", str(s.judgments_same), ""),
        ("  of a command with another video", str(s.judgments_different), ""),
        *((f"outcomes, {name}", str(n), "") for name, n in s.outcomes.items()),
    ]
    return "\n".join(columns([row[:2] for row in rows] if s.is_authored else rows))


def _command(corpus: Corpus, command: Command) -> str:
    ids = [a.id for a in corpus.annotations if a.command.id == command.id]
    return "\n".join(
        [
            f"command {command.id}",
            f"  {command.text.strip()!r}",
            f"  scenario {command.scenario}, video {command.video or '?'}, "
            f"subject {command.subject or '?'}",
            f"  annotations: {', '.join(ids) or 'none'}",
            *(f"  done: {_outcome(corpus, o)}" for o in outcomes_of(corpus, command)),
        ]
    )


def _annotation(annotation: Annotation) -> str:
    rows: list[tuple[str, ...]] = [("clause", "words", "grounded in", "label")]
    clauses = breadth_first(annotation.sdcs)
    for sdc, groundings, label in zip(
        clauses, annotation.groundings, annotation.correct, strict=True
    ):
        grounded = "; ".join(map(_grounding, groundings)) or "-"
        words = " ".join(span.text for span in all_words(sdc)) or "(implicit)"
        rows.append((sdc.type, words, grounded, LABELS[label]))
    taken_back = " ".join(span.text for span in annotation.taken_back)
    return "\n".join(
        [
            f"annotation {annotation.id} ({annotation.source})",
            f"  {annotation.command.text.strip()!r}",
            f"  context {annotation.context.id}",
            "",
            *([format_brackets(annotation.sdcs)] if annotation.sdcs else ["asks for nothing"]),
            *([f"taken back: {taken_back}"] if taken_back else []),
            "",
            *columns(rows),
        ]
    )


def _outcome(corpus: Corpus, outcome: TaskOutcome) -> str:
    """Describe an outcome in words, with its unknown parts."""
    labels = {o.id: " ".join(o.labels) for o in corpus.contexts[outcome.context].objects}

    def named(ids: Sequence[str]) -> str:
        return " or ".join(f"{labels[i]} {i}" for i in ids) or "something"

    parts = [
        "drove" if is_drive(outcome) else f"picked up {named(outcome.picked)}",
        {"on": f"put it on {named(outcome.on)}", "ground": "put it down", "held": "held it"}.get(
            outcome.put, ""
        ),
        "" if outcome.checkpoint is None else f"at checkpoint {outcome.checkpoint}",
    ]
    summary = ", ".join(filter(None, parts))
    return f"{summary} (unknown: {', '.join(outcome.unknown)})" if outcome.unknown else summary


def _context(corpus: Corpus, context: Context) -> str:
    rows: list[tuple[str, ...]] = [("object", "labels", "starts at", "moves")]
    rows += [
        (
            item.id + (" (agent)" if item.id == context.agent_id else ""),
            " ".join(item.labels),
            _position(item.trajectory),
            _motion(item.trajectory),
        )
        for item in context.objects
    ]
    assumed: dict[str, list[str]] = {}
    for name, aspect in context.assumed:
        assumed.setdefault(aspect, []).append(name)
    done = [_outcome(corpus, o) for o in corpus.outcomes if o.context == context.id]
    return "\n".join(
        [
            f"context {context.id}, {len(context.places)} places",
            "",
            *columns(rows),
            *(["", *(f"done: {text}" for text in done)] if done else []),
            *([""] if assumed else []),
            *(f"assumed {aspect}: {', '.join(names)}" for aspect, names in assumed.items()),
        ]
    )


def _grounding(grounding: Grounding) -> str:
    if isinstance(grounding, PhysicalObject):
        return f"{' '.join(grounding.labels)} {grounding.id}"
    if isinstance(grounding, Place):
        x, y = grounding.prism.xy.mean(axis=0)
        return f"{grounding.name or 'place'} at ({x:.1f}, {y:.1f}) m"
    return f"path of {_motion(grounding.trajectory)}"


def _position(trajectory: Trajectory) -> str:
    x, y, z = trajectory.xyz[0]
    return f"({x:.1f}, {y:.1f}, {z:.1f}) m, {np.degrees(trajectory.yaw[0]):.0f}°"


def _motion(trajectory: Trajectory) -> str:
    if len(trajectory) == 1:
        return "-"
    steps = np.diff(trajectory.xyz, axis=0)
    length_m = float(np.sqrt((steps**2).sum(axis=1)).sum())
    return f"{length_m:.1f} m in {trajectory.t[-1] - trajectory.t[0]:.0f} s"


def excerpt(corpus: Corpus, name: str) -> Mapping[str, object]:
    """Return the command, annotation, context or outcome with an id, and the records around it.

    A command brings its annotations and what was done, an annotation its command and its context.
    An outcome brings its context. ``commands``, ``annotations``, ``contexts`` and ``outcomes`` are
    lists of records; their numbers point to ``trajectories``: lists of ``t`` in s, ``xyz`` in m and
    ``yaw`` in rad.
    """
    annotations = tuple(a for a in corpus.annotations if name in (a.id, a.command.id))
    commands = {a.command.id: a.command for a in annotations}
    contexts = {a.context.id: a.context for a in annotations}
    outcomes = tuple(
        outcome
        for outcome in corpus.outcomes
        if name in (outcome.id, outcome.context)
        or (name in corpus.commands and belongs_to(outcome, corpus.commands[name]))
    )
    contexts |= {outcome.context: corpus.contexts[outcome.context] for outcome in outcomes}
    commands |= {key: value for key, value in corpus.commands.items() if key == name}
    contexts |= {key: value for key, value in corpus.contexts.items() if key == name}
    tables = encode(Content(contexts, commands, annotations, (), outcomes))
    return {
        "commands": tables.commands,
        "annotations": tables.annotations,
        "contexts": tables.contexts,
        "outcomes": tables.outcomes,
        "trajectories": list(as_lists(tables.trajectories)),
    }
