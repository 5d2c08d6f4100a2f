"""What kinds of objects look like: geoms that don't collide, one module a family of things.

:func:`~corpus_tools.world.looks.registry.look` registers the look of a kind.
"""
