"""Names of people on pages: their login, else a short name made of the hash that exports have."""

from __future__ import annotations

from annotation_app.people.participants import subject_of
from annotation_app.store.models import Person

_COLOURS = (
    "Amber", "Ash", "Azure", "Beige", "Black", "Blue", "Bronze", "Brown", "Cherry", "Coral",
    "Cream", "Crimson", "Cyan", "Emerald", "Gold", "Green", "Grey", "Hazel", "Indigo", "Ivory",
    "Jade", "Lemon", "Lilac", "Lime", "Maroon", "Mint", "Ochre", "Olive", "Opal", "Orange",
    "Pearl", "Pink", "Plum", "Purple", "Red", "Rose", "Ruby", "Silver", "Teal", "White",
)  # fmt: skip
_BIRDS = (
    "Avocet", "Bittern", "Bunting", "Chough", "Crane", "Curlew", "Dipper", "Dove", "Dunlin",
    "Egret", "Falcon", "Finch", "Gannet", "Grouse", "Gull", "Heron", "Hobby", "Ibis", "Jay",
    "Kestrel", "Kite", "Lark", "Linnet", "Magpie", "Martin", "Merlin", "Oriole", "Osprey", "Owl",
    "Plover", "Puffin", "Quail", "Raven", "Robin", "Rook", "Siskin", "Swan", "Swift", "Tern",
    "Wren",
)  # fmt: skip


def short_name(subject: str) -> str:
    """Return an easy name for a person, which reveals nothing about them.

    Parameters
    ----------
    subject
        The person's name in exports, a part of a hash. Other names stay as they are.

    Examples
    --------
    >>> short_name("1bb3585e3769")
    'Silver Robin 80'
    """
    try:
        number = int(subject, 16)
    except ValueError:
        return subject
    number, bird = divmod(number, len(_BIRDS))
    number, colour = divmod(number, len(_COLOURS))
    return f"{_COLOURS[colour]} {_BIRDS[bird]} {number % 90 + 10}"


def anonymous_name(person: Person) -> str:
    """Return a person's short name, which exports have, too."""
    return short_name(subject_of(person))


def shown_name(person: Person) -> str:
    """Return a person's name on the dashboard."""
    return person.login or anonymous_name(person)
