"""Kinds of things that can stand in a world.

What a kind looks like is registered in :mod:`corpus_tools.world.looks`, how it collides in
:mod:`corpus_tools.world.state.solids`; this module knows no simulator. Other distributions
name modules that register kinds in the entry point group ``ct.kinds``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from g3.groundings import Colour
from g3.registry import Registry
from g3.short_repr import short_repr

PAINTS: Mapping[Colour, tuple[float, float, float]] = {
    "black": (0.10, 0.10, 0.11),
    "white": (0.98, 0.98, 0.96),
    "grey": (0.52, 0.53, 0.55),
    "red": (0.85, 0.10, 0.09),
    "green": (0.12, 0.58, 0.20),
    "yellow": (1.00, 0.84, 0.08),
    "blue": (0.10, 0.27, 0.80),
    "brown": (0.45, 0.26, 0.12),
    "orange": (1.00, 0.48, 0.05),
    "pink": (1.00, 0.52, 0.68),
    "purple": (0.48, 0.18, 0.62),
}
"""Red, green and blue of each named colour, from 0 to 1, in pictures and in the scenes of logs."""


@short_repr
@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of object. Its frame is at its pose: x ahead, y to the left, z up."""

    name: str
    """Name in scenarios."""
    labels: tuple[str, ...]
    """Names of objects of the kind in the semantic map."""
    size: tuple[float, float]
    """Footprint along and across the heading, in metres."""
    heights: tuple[float, float]
    """Bottom and top above what it stands on, in metres. Loads stand on the top of a kind with a
    deck."""
    ahead_m: float = 0.0
    """Distance of the middle of the footprint ahead of the pose, in metres."""
    carriable: bool = False
    """True if the forks can lift it."""
    deck: tuple[float, float] | None = None
    """Part of the top that can be loaded, from and to along the heading in metres; None if nothing
    can stand on it."""


KINDS: Registry[Kind] = Registry("kind", "ct.kinds")
"""All kinds by name."""


def register_kind(kind: Kind) -> Kind:
    """Make a kind known to scenarios.

    Raises
    ------
    ValueError
        If another kind has its name.
    """
    return KINDS.add(kind)


FORKLIFT = register_kind(Kind("forklift", ("forklift",), (1.75, 1.2), (0.0, 2.1), ahead_m=-0.325))
"""The robot. Its pose is on the ground between the front wheels."""

TIRE_PALLET = register_kind(
    Kind("tire-pallet", ("tire", "pallet"), (1.0, 1.2), (0.0, 0.7), carriable=True)
)
BOX_PALLET = register_kind(
    Kind("box-pallet", ("box", "pallet"), (1.0, 1.2), (0.0, 1.05), carriable=True)
)
CRATE = register_kind(Kind("crate", ("crate",), (1.0, 1.0), (0.0, 0.9), carriable=True))
TRAILER = register_kind(Kind("trailer", ("trailer",), (5.4, 2.0), (0.45, 0.85), deck=(-2.7, 2.7)))
TRUCK = register_kind(Kind("truck", ("truck",), (6.2, 2.2), (0.5, 1.0), deck=(-3.1, 1.3)))
SHELF = register_kind(Kind("shelf", ("shelf",), (3.0, 1.0), (0.0, 2.6)))
BARREL = register_kind(Kind("barrel", ("barrel",), (0.6, 0.6), (0.0, 0.9)))
PERSON = register_kind(Kind("person", ("person",), (0.5, 0.5), (0.0, 1.75)))
CONE = register_kind(Kind("cone", ("cone",), (0.4, 0.4), (0.0, 0.7)))

for _name, _height in (
    ("refrigerator-pallet", 1.95),
    ("washing-machine-pallet", 1.05),
    ("generator-pallet", 1.25),
    ("generator-accessories-pallet", 1.0),
    ("bricks-pallet", 0.9),
):
    register_kind(Kind(_name, tuple(_name.split("-")), (1.0, 1.2), (0.0, _height), carriable=True))
register_kind(replace(TRUCK, name="flatbed-truck", labels=("flatbed", "truck")))
register_kind(
    replace(
        TRUCK, name="semi-truck", labels=("semi", "truck"), size=(6.6, 2.5), heights=(0.55, 1.1)
    )
)
register_kind(Kind("container", ("container",), (6.1, 2.4), (0.0, 2.6)))
register_kind(Kind("sign", ("sign",), (0.3, 0.9), (0.0, 2.4)))
register_kind(Kind("berm", ("berm",), (6.0, 2.5), (0.0, 1.4)))

OTHER = register_kind(Kind("other", (), (1.0, 1.0), (0.0, 1.0)))
"""Kind of objects that fit no other kind's labels."""

_OTHER_WORDS = {
    "truck": "lorry",
    "box": "boxes",
    "tire": "tires",
    "person": "man human operator",
    "shelf": "rack",
    "barrel": "drum",
    "refrigerator": "fridge fridges refrigerators",
    "washing": "washer",
    "machine": "machines",
    "generator": "generators",
    "bricks": "brick",
    "sign": "signpost",
    "semi": "tractor",
    "berm": "mound heap",
}
"""Our labels, and those of other corpora that mean the same."""
_SAME_AS = {other: ours for ours, others in _OTHER_WORDS.items() for other in others.split()}


def kind_of(labels: Iterable[str]) -> Kind:
    """Return the kind whose labels fit best, :data:`OTHER` if none has a label in common.

    Labels of other corpora are understood, of one word or several: {tire, assembly, pallet} is a
    tire pallet, {ship container} a container, {flatbed, trailer} a trailer. Of kinds that fit as
    well the first that was registered is taken.
    """
    words = re.findall("[a-z]+", " ".join(labels).lower())
    nouns = {_SAME_AS.get(word, word) for word in words}
    best = max(KINDS.values(), key=lambda kind: len(nouns.intersection(kind.labels)))
    return best if nouns.intersection(best.labels) else OTHER


KINDS.load_others()
