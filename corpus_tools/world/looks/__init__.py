"""Looks of kinds of objects: geoms that don't collide, one module a family of things.

Read :mod:`~corpus_tools.world.looks.look_registry` first, then any family, such as
:mod:`~corpus_tools.world.looks.pallets`. A family makes things of surfaces
(:mod:`~corpus_tools.world.looks.parts`) coloured from one picture
(:mod:`~corpus_tools.world.looks.atlas`).

Things of a kind have the same colours. The semantic map knows no colours, so people who
describe what they see shouldn't distinguish things by them.

Other distributions name modules that register looks in the entry point group ``ct.looks``.
"""

from corpus_tools.world.looks import furniture, pallets, people, vehicles
from corpus_tools.world.looks.look_registry import LOOKS

__all__ = ["furniture", "pallets", "people", "vehicles"]

LOOKS.load_others()
