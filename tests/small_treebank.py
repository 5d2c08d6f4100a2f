"""A treebank small enough to learn from in a test: two people in each of two domains."""

from __future__ import annotations

import json
from pathlib import Path

GO = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the {})))"
PUT = "EVENT(r = Put, l = OBJ(f = the {}), l2 = PLACE(r = on, l = OBJ(f = the {})))"
PEOPLE = (("p1", "yard", 1), ("p2", "house", 1), ("p3", "yard", 2), ("p4", "house", 2))
THINGS = {"yard": ("pallet", "truck"), "house": ("cup", "table")}


def tree_rows() -> list[dict[str, object]]:
    """Rows of trees.jsonl: four commands a person, one takes words back, one asks for nothing."""
    rows: list[dict[str, object]] = []
    for person, domain, _ in PEOPLE:
        thing, place = THINGS[domain]
        commands: list[tuple[str, list[str], str]] = [
            (f"Go to the {place}.", [GO.format(place)], ""),
            (f"Put the {thing} on the {place}.", [PUT.format(thing, place)], ""),
            (f"Go to the {thing}, no, to the {place}.", [GO.format(place)], f"to the {thing}"),
            ("Good morning!", [], ""),
        ]
        for number, (text, trees, taken_back) in enumerate(commands, start=1):
            row = {"id": f"{person}-{number}", "person": person, "domain": domain}
            row |= {"text": text, "trees": trees}
            rows.append(row | ({"taken_back": taken_back} if taken_back else {}))
    return rows


def write_treebank(folder: Path) -> Path:
    """Write the treebank, and return its folder."""
    folder.mkdir()
    people = [{"person": p, "domain": d, "split_group": g} for p, d, g in PEOPLE]
    for name, rows in (("trees.jsonl", tree_rows()), ("people.jsonl", people)):
        (folder / name).write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    return folder
