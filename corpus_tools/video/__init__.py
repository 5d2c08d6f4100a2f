"""Videos of recordings, drawn without a screen.

In ``drawing``, ``gl`` chooses how to draw, ``camera`` from where, ``drawn_moments`` when.
``canvas`` draws one picture. Before a fixed camera ``composite`` draws only what moves, with the
shadows of ``shadows`` or without; ``shaded`` draws for cameras that move. ``segmentation`` maps
the objects in the first frame. Here, ``encode`` makes the file that browsers play, ``films`` does
all of this for a recording, ``production`` for items.
"""
