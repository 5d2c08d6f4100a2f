"""The files that ``ct annotate init`` writes, and what studies are called. It needs no extra."""

from __future__ import annotations

import re

TEMPLATE = """\
# A study. docs/annotation.md lists all fields. Start it with: ct annotate {name}.yaml
name: {name}
title: Commands for a robot forklift

# A folder, from this file, that was made with: ct render-videos --out videos
videos: videos

# answers: how many people answer each item. lease_minutes: how long somebody has an item
# before somebody else may get it. role: worker (everybody, unless you say otherwise) or annotator
# (people with a login, whom you invite with: ct annotate people invite --role annotator).
# suggestions: on, off, or half of the items. practice: false leaves out the practice example.
tasks:
  describe: {{answers: 13, lease_minutes: 20}}
  segment: {{answers: 1, lease_minutes: 60}}
  ground: {{answers: 1, lease_minutes: 60}}
  check: {{answers: 1, lease_minutes: 60}}
  rate: {{answers: 5, lease_minutes: 20}}

# open: whoever has the address may take part; invited: who has a link of their own.
access: open

# What your robot is called. It takes the place of {{robot}} in consent and statement.
robot: forklift

consent: |
  You will watch short videos of a robot {{robot}}, or read what others wrote about them.
  What you type and choose is kept without your name and may be published for research.
  You may stop at any time by closing the page.

questions:
  - {{id: english, text: Is English your first language?, choices: ["Yes", "No"]}}

qualification:
  - I am at least 18 years old.

# For each item.
payment: {{amount: 0.25, currency: USD}}

# Part of a rater's items whose right answer is known, and what they are made of:
# attention_checks: 0.1
# known_commands:
#   - {{text: Pick up the tires., video: pick_up_tires, wrong_video: drive_to_truck}}
"""

OWN_TEMPLATE = """\
# A study of your own videos. docs/annotation.md lists all fields.
# Check it with: ct annotate check {name}.yaml. Start it with: ct annotate {name}.yaml
name: {name}
title: Commands for a robot

# A folder of mp4 and webm files, or a table (CSV or JSONL) with the columns video and, if you
# like, id and others of your own, which exports tell too. Paths begin at this file.
videos: {videos}

# A table with the columns video and command, for commands that you have already:
{commands}

# What your robot is called. It takes the place of {{robot}} in consent and statement.
robot: arm
statement: The {{robot}} in the video is executing the above spoken command.
scale: [Strongly disagree, Disagree, Neither agree nor disagree, Agree, Strongly agree]

# The tasks ground and check need to know what is where, which no video file tells.
# instructions are Markdown; left out, people read the task's own.
tasks:
  describe:
    answers: 3
    instructions: |
      1. Watch the video to its end. You may watch it again as often as you like.
      2. Imagine that you had told the robot to do **exactly this**. Type the command that you
         would have given, in your own words.
  segment: {{answers: 1, lease_minutes: 60}}
  rate: {{answers: 3}}

access: open

consent: |
  You will watch short videos of a robot {{robot}}, or read what others wrote about them.
  What you type and choose is kept without your name and may be published for research.
  You may stop at any time by closing the page.
"""

EPISODES_TEMPLATE = """\
# A study of robot episodes. docs/how-to/robot-episodes.md shows the whole way.
# Check it with: ct annotate check {name}.yaml. Start it with: ct annotate {name}.yaml
name: {name}
title: What a robot does

# Tables of the dataset: its episodes, its tasks, and its subtasks. Paths begin at this file.
{tables}

# What your robot is called. It takes the place of {{robot}} in consent.
robot: arm

# answers: how many people answer each item. practice: false leaves out the practice example.
# docs/annotation.md lists all fields.
tasks:
  describe: {{answers: 3}}
  subtasks: {{answers: 3}}
{given_tasks}  mark: {{answers: 3, adoption: majority}}

access: open

consent: |
  You will watch short videos of a robot {{robot}}, and write or judge what it does.
  What you type and choose is kept without your name and may be published for research.
  You may stop at any time by closing the page.
"""


GIVEN_TASKS = """\
  correct: {answers: 3, adoption: majority}
"""
"""Tasks of studies whose dataset has task strings."""


def slug(text: str) -> str:
    """Return a name for addresses, made of a title, or of the name of a file or a corpus."""
    return re.sub(r"[^a-z0-9]+", "-", text.casefold()).strip("-")[:60].strip("-") or "study"
