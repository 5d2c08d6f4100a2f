"""A corpus's commands as tasks of Label Studio, with the clauses as predictions.

Import ``tasks.json`` into a project with the labels of ``label-config.xml``. Each run of words of a
clause is a region. A clause with several runs, such as "Put … down", has a relation ``same clause``
between them; a clause inside another one has the relation that is its field.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import msgspec

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation
from g3.sdc.clauses import CHILD_FIELDS, SDC, SDC_TYPES, Span, breadth_first, child_indices

FROM, TO = "clause", "command"
"""Names of the labels and of the text in the configuration."""
SAME = "same clause"
RELATIONS = {"f": "figure", "l": "landmark", "l2": "second landmark"}
COLOURS = ("#c0392b", "#2471a3", "#1e8449", "#b7950b")


def label_studio_files(corpus: Corpus) -> dict[str, bytes]:
    """Return the tasks, and the configuration of a project for them."""
    annotated: dict[str, Annotation] = {}
    for annotation in corpus.annotations:
        annotated.setdefault(annotation.command.id, annotation)
    tasks = []
    for command in corpus.commands.values():
        data = {
            "command": command.text,
            "command_id": command.id,
            "scenario": command.scenario,
            "video": command.video,
        }
        task: dict[str, Any] = {"data": data}
        if command.id in annotated:
            result = list(_regions(command.text, annotated[command.id].sdcs))
            task["predictions"] = [{"model_version": corpus.name, "result": result}]
        tasks.append(task)
    encoded = msgspec.json.format(msgspec.json.encode(tasks), indent=2)
    return {"tasks.json": encoded + b"\n", "label-config.xml": _config(_video(corpus)).encode()}


def _video(corpus: Corpus) -> str:
    """Return the tag that shows videos: by address, else by name; empty without videos."""
    named = [command.video for command in corpus.commands.values() if command.video]
    if not named:
        return ""
    playable = all(video.startswith(("http://", "https://", "/data/")) for video in named)
    tag = 'Video name="video"' if playable and len(named) == len(corpus.commands) else "Header"
    return f'  <{tag} value="$video"/>\n'


def _config(video: str) -> str:
    labels = "\n".join(
        f'    <Label value="{name}" background="{colour}"/>'
        for name, colour in zip(SDC_TYPES, COLOURS, strict=True)
    )
    relations = "\n".join(f'    <Relation value="{name}"/>' for name in (*RELATIONS.values(), SAME))
    return (
        f'<View>\n  <Relations>\n{relations}\n  </Relations>\n  <Labels name="{FROM}" '
        f'toName="{TO}">\n{labels}\n  </Labels>\n{video}'
        f'  <Text name="{TO}" value="${TO}"/>\n</View>\n'
    )


def _regions(text: str, sdcs: Sequence[SDC]) -> Iterator[dict[str, Any]]:
    nodes, below = list(breadth_first(sdcs)), child_indices(sdcs)
    first: dict[int, str] = {}
    for node, sdc in enumerate(nodes):
        names = []
        for number, run in enumerate(_runs(text, (*sdc.relation, *sdc.words))):
            names.append(f"{node}-{number}")
            start, end = run
            value = {"start": start, "end": end, "text": text[start:end], "labels": [sdc.type]}
            yield {
                "id": names[-1], "from_name": FROM, "to_name": TO, "type": "labels", "value": value,
            }  # fmt: skip
        if names:
            first[node] = names[0]
        yield from (_relation(names[0], name, SAME) for name in names[1:])
    for node, fields in enumerate(below):
        for name in CHILD_FIELDS:
            for child in fields.get(name, ()):
                if node in first and child in first:
                    yield _relation(first[node], first[child], RELATIONS[name])


def _relation(start: str, end: str, label: str) -> dict[str, Any]:
    return {
        "type": "relation", "from_id": start, "to_id": end, "direction": "right", "labels": [label],
    }  # fmt: skip


def _runs(text: str, words: Sequence[Span]) -> list[tuple[int, int]]:
    """Words with nothing but white space between them are one region."""
    runs: list[tuple[int, int]] = []
    for word in sorted(words, key=lambda word: word.start):
        if runs and not text[runs[-1][1] : word.start].strip():
            runs[-1] = (runs[-1][0], word.end)
        else:
            runs.append((word.start, word.end))
    return runs
