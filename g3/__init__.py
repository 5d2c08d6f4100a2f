"""Generalized Grounding Graphs: the model of Tellex et al. (AAAI 2011).

The package knows nothing of files, simulators, web servers or the command line.
Read :mod:`g3.sdc` first (what a command is made of), then :mod:`g3.groundings`
(what it can mean), :mod:`g3.annotation` (both together), :mod:`g3.graph` (the
factor graph), :mod:`g3.features` and :mod:`g3.crf` (the learned model).
"""
