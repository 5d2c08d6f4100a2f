"""The file that ``ct annotate init`` writes."""

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

consent: |
  You will watch short videos of a robot forklift, or read what others wrote about them.
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
