"""Scenarios: layouts of objects and places, and the robot's script.

They are files that people write (``docs/scenarios.md``) or that are generated. Read
:mod:`~corpus_tools.world.scenarios.scenario` (what a scenario holds) first, then
``scenario_reading``, ``scenario_validation`` (whether it can be so), ``contexts`` (the semantic
map it stands for) and ``random`` (generated ones).
"""
