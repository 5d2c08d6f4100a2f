"""Videos of recordings, drawn without a screen.

In ``drawing``, ``gl`` chooses how to draw, ``camera`` from where, ``drawn_moments`` when.
``canvas`` draws one picture. Before a fixed camera ``pasted`` draws only what moves, ``composite``
with the shadows of ``shadows``; ``shaded`` draws for cameras that move. ``segmentation`` maps
the objects in the first frame. Here, ``frame_renderers`` chooses among these, ``encode`` makes the
file that browsers play, ``production`` does all of this for one item, ``render_batch`` for many.
"""
