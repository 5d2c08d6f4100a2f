"""The kind of load "cable reel", for scenarios and physics; knows no simulator."""

from corpus_tools.world.state.thing_kinds import Kind, register_kind

CABLE_REEL = register_kind(
    Kind("cable-reel", ("cable", "reel"), size=(1.0, 1.0), heights=(0.0, 1.1), carriable=True)
)
