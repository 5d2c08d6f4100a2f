"""A made-up folder of random tasks, in the layout of forklift.automatic.v1."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

UPRIGHT, TURNED = "1 0 0 0", "0.70710678 0 0 0.70710678"
"""Headings of 0° and of 90°, as quaternions w, x, y, z."""

COMMANDS = """\
- {assignmentId: A1, command: Pick up the fridge., hitId: H, workerId: WORKER1, youtubeId: vid}
- {assignmentId: A2, command: 'Lift it. ', hitId: H, workerId: WORKER2, youtubeId: vid}
"""
PROPERTIES = "{isSimulated: true, platform: forklift, youtubeId: vid}\n"


def pallet(name: str, label: str, at: str, heading: str = UPRIGHT) -> str:
    return f"""<item type="pallet"><id>{name}</id><type id="pallet_enum_t">6</type>
        <label>{label}</label><position id="local-frame">{at}</position>
        <position id="lat_lon_theta">37.2 -77.3 0.5</position>
        <orientation id="local-frame">{heading}</orientation></item>"""


def thing(name: str, kind: str, at: str, heading: str = UPRIGHT) -> str:
    return f"""<item type="object"><id>{name}</id><type id="object_enum_t">{kind}</type>
        <position id="local-frame">{at}</position>
        <orientation id="local-frame">{heading}</orientation></item>"""


def objects(*items: str) -> str:
    return f'<?xml version="1.0" ?><objects>{"".join(items)}</objects>'


def log(*tasks: str, start: str = "Teleporting to: -10.0, 2.0") -> str:
    return "\n".join(
        [
            "", "", "Starting...", "manipulations: 1", "destinations: 0", "ok", "ok",
            "on_pallet_list(): Added 2 pallets", "entering while loop",
            "x, y, -6.682, 29.483 dist: 5.539", "dist < 10: 1", start,
            "Currently 1 manipulation and 0 summoning tasks remaining.", *tasks,
            "Start 0 manipulation and 0 summoning tasks remaining.", "Looks like we're done", "",
        ]
    )  # fmt: skip


PICK_UP = "Generating PMC Task: Pickup pallet_id = {} without a drop-off"
TO_TRAILER = "Generating PMC Task: Pickup pallet_id = {} and drop-off on trailer."
TO_CHECKPOINT = "Generating PMC Task: Pickup pallet_id = {} and drop-off at checkpoint_id = {}"
DRIVE = "Generating Summoning Pose: Destination is checkpoint_id = {}"

YARD = objects(
    pallet("11", "19", "1 2 0"),
    pallet("12", "25", "1 -4 0", TURNED),
    thing("13", "5", "0 10 0.0"),
    thing("14", "8", "5 5 0.3", TURNED),
)
"""A refrigerator, a washing machine, a trailer and an operator."""


def put_world(
    group: Path,
    name: str = "2011_1_manip",
    *,
    xml: str | bytes | None = YARD,
    status: str | bytes | None = log(PICK_UP.format("11")),
    commands: str | bytes | None = COMMANDS,
    properties: str | bytes | None = PROPERTIES,
) -> Path:
    """Write the folder of a video; a file that is None is missing."""
    folder = group / name
    folder.mkdir(parents=True)
    files: Mapping[str, str | bytes | None] = {
        "objects.xml": xml,
        "simSupervisorStatus.txt": status,
        "assignments.yaml": commands,
        "properties.yaml": properties,
    }
    for file, content in files.items():
        if content is not None:
            data = content.encode() if isinstance(content, str) else content
            (folder / file).write_bytes(data)
    return folder
