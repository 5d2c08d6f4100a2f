"""A layout and a scenario for tests."""

LAYOUT = """\
title: A floor.
at: [10, 20]
yaw_deg: 90
bounds: {x: [-20, 20], y: [-15, 15]}
objects:
  shelf-a: {kind: shelf, at: [0, 14]}
places:
  receiving: {name: receiving, at: [15, 0], size: [5, 5]}
"""
SCENARIO = """\
title: The forklift puts tires on the trailer.
layout: floor
objects:
  tires-1: {kind: tire-pallet, at: [7, 1.5]}
  boxes-1: {kind: box-pallet, deck: trailer-1, at: [1, 9.55], yaw_deg: 90}
  boxes-2: {kind: box-pallet, at: [7, -3]}
  trailer-1: {kind: trailer, at: [1, 10]}
places:
  on-trailer-1: {deck: trailer-1, at: [2.6, 9.55], yaw_deg: 90}
  corner: {at: [-15, -10]}
robot: {at: [0, 0]}
script:
  - pick_up: tires-1
  - put_down: on-trailer-1
"""
