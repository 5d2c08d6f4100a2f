"""Classes of words that decide how a command is built.

Hand-made from general knowledge: verbs by what they take (a place, a source, a way), words of
direction, words that measure. With a few hundred commands most verbs occur too rarely to learn
from what each takes.
"""

from __future__ import annotations

from functools import lru_cache

CLASSES = {
    "placing": "put place set drop deposit lay leave lower position stack stand park release "
    "unload dump rest store stow settle line arrange insert install mount hang",
    "taking": "pick take get grab lift raise remove fetch collect retrieve grasp hoist pull "
    "seize hold unload detach extract gather acquire",
    "carrying": "move bring carry transfer transport haul deliver relocate shift push load "
    "return drag ship convey shuttle send lug slide run",
    "going": "go drive head proceed travel continue advance approach come walk roll pass cross "
    "enter exit leave back reverse follow reach navigate steer maneuver cruise retreat",
    "turning": "turn spin rotate swing swerve pivot face veer circle twist",
    "staying": "stop wait stay halt pause remain keep stand hold idle park",
    "side": "left right front rear back side middle center centre end corner edge top bottom "
    "leftmost rightmost far near north south east west",
    "way": "forward forwards backward backwards ahead straight up down around over off away out "
    "back across along past through leftward rightward left right sideways",
    "measure": "foot feet ft meter meters metre metres inch inches degree degrees bit little "
    "square squares slot slots length lengths width yard yards unit units spot spots half",
    "order": "first second third fourth fifth last next nearest closest furthest farthest other "
    "leftmost rightmost only",
    "negating": "not n't nt never without",
    "counting": "all both each every any some half",
    "exactly": "directly just right immediately slightly exactly straight all somewhat "
    "approximately about almost well further",
    "being": "is are was be being been located sitting standing situated placed resting",
    "relative": "that which who",
    "until": "until till when while once after before if so as like",
    "polite": "please kindly now ok okay then first next finally",
    "you": "you your yourself i me my we us",
    "it": "it them they one ones its their itself",
}

_BY_WORD: dict[str, str] = {}
for _name, _words in CLASSES.items():
    for _word in _words.split():
        _BY_WORD[_word] = f"{_BY_WORD[_word]}+{_name}" if _word in _BY_WORD else _name


@lru_cache(maxsize=65536)
def word_class(word: str) -> str:
    """The classes of a word, joined by "+"; empty if none is known.

    >>> word_class("putting"), word_class("carries"), word_class("pallet")
    ('placing', 'carrying', '')
    """
    for stem in _stems(word):
        if stem in _BY_WORD:
            return _BY_WORD[stem]
    return ""


def _stems(word: str) -> tuple[str, ...]:
    stems = [word]
    if word.endswith("ing") and len(word) > 5:
        stem = word[:-3]
        stems += [stem, f"{stem}e", stem[:-1]]
    if word.endswith("ies"):
        stems.append(f"{word[:-3]}y")
    if word.endswith("es"):
        stems.append(word[:-2])
    if word.endswith("s") and not word.endswith("ss"):
        stems.append(word[:-1])
    if word.endswith("ed") and len(word) > 4:
        stems += [word[:-1], word[:-2], word[:-3]]
    return tuple(stems)
