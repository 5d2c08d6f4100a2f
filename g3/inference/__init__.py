"""Inference: from a command and a state to groundings and a plan (section 3.4).

Read :mod:`~g3.inference.grounder` first. ``problem`` is a command with a state and candidates, and
what a factor's groundings cost. ``potentials`` are the hand-written rules. ``search`` finds the
groundings of OBJECTs and PLACEs, then action sequences for EVENTs and PATHs. ``reasons`` explains
them. ``training`` makes the examples that inference needs in addition to a corpus's own. Importing
the package registers the potentials.
"""

from g3.inference import potentials

__all__ = ["potentials"]
