"""The simulated world: scenarios, physics, and recordings.

Read :mod:`~corpus_tools.world.state.thing_kinds` and
:mod:`~corpus_tools.world.state.recording` first. A scenario (``scenarios``) is set up as a
:class:`g3.groundings.Context` and executed with contact physics (``physics``). That gives a
:class:`~corpus_tools.world.state.recording.Recording`, of which videos and logs are made.
Imports run one way: ``state`` ← ``planning`` ← ``physics`` ← ``scenarios``.
"""
