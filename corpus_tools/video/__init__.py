"""Videos of recordings, drawn without a screen.

In ``drawing``, ``gl`` chooses how to draw, ``camera`` from where, ``drawn_moments`` when.
``canvas`` draws one picture; ``full`` draws whole frames one by one, ``composite`` only what moves
before a fixed camera, with the shadows of ``shadows``. ``segmentation`` says what is where in the
first frame. Here, ``frame_renderers`` chooses among these, ``encode`` makes the file that browsers
play, ``production`` does all of this for one item, and ``render_batch`` for many.
"""
