"""Videos of recordings, drawn without a screen.

In ``drawing``, ``gl`` chooses how to draw, ``camera`` from where, ``drawn_moments`` when.
``canvas`` draws one picture; before a fixed camera ``composite`` draws only what moves, with the
shadows of ``shadows``. ``segmentation`` says what is where in the first frame. Here,
``frame_renderers`` chooses how frames are drawn, ``encode`` makes the file that browsers
play, ``production`` does all of this for one item, and ``render_batch`` for many.
"""
