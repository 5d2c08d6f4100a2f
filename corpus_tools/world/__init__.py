"""The simulated world: scenarios, physics, and what happened in it.

Read :mod:`~corpus_tools.world.kinds` and :mod:`~corpus_tools.world.recording` first. A
scenario (``scenarios``) is set up as a :class:`g3.groundings.Context`, executed with
contact physics (``execute``), and the :class:`~corpus_tools.world.recording.Recording`
that this gives is what videos and logs are made of.
"""
