"""Made-up examples of phrases of paths, in the form of spatialRelations.stefie10.yaml."""

from __future__ import annotations

import bz2
from pathlib import Path

EXAMPLE = """\
- agent: &{name}
    lcmId: -100
    path: &{name}path
      points_xyztheta: [[0.0, 0.0, 0.0, 0.0], [{x}, 0.0, 0.0, 0.0], [{x}, 3.0, 0.0, 1.6]]
      timestamps: ['0', '1', '2']
    prism: {{points: [[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]], zStart: 0.0, zEnd: 1.0}}
    tag: []
  assignmentId: sr_{relation}_{number}
  command: ['{relation} the {landmark}.', [PATH: {{l: the {landmark}, r: {relation}}}]]
  context: {{objects: [], places: []}}
  groundingIsCorrect: [{label}, true]
  objectGroundings:
  - - [Path, *{name}path]
  - - - PhysicalObject
      - lcmId: null
        path: {{points_xyztheta: [[5.0, 0.0, 0.5, 0.0]], timestamps: ['0']}}
        prism: {{points: {points}, zStart: 0.0, zEnd: 1.0}}
        tag: [{landmark}]
"""
DESK = "[[4, -1], [6, -1], [6, 1], [4, 1]]"
POINT = "[[5.0, 0.0], [5.0, 0.0002], [5.0002, 0.0], [5.0002, 0.0002]]"


def example(relation: str, landmark: str, number: int, label: str, *, x: float, points: str) -> str:
    return EXAMPLE.format(
        name=f"w{number}", relation=relation, landmark=landmark, number=number, label=label,
        x=x, points=points,
    )  # fmt: skip


EXAMPLES = "".join(
    [
        example("past", "desk", 0, "true", x=8, points=DESK),
        example("past", "desk", 1, "false", x=2, points=DESK),
        example("to", "desk", 2, "false", x=8, points=DESK),
        example("past", "chair", 3, "false", x=8, points=POINT),
    ]
)


def put_phrases(folder: Path) -> Path:
    """Write the examples into a folder."""
    folder.mkdir(parents=True)
    file = folder / "spatialRelations.someone.yaml.bz2"
    file.write_bytes(bz2.compress(EXAMPLES.encode()))
    return file
