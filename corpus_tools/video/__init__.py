"""Videos of recordings, drawn without a screen.

``gl`` chooses how to draw, ``camera`` from where, ``moments`` when. ``canvas`` draws one
picture; ``full`` draws whole frames one by one, ``composite`` only what moves before a fixed
camera, with the shadows of ``shadows``. ``encode`` makes the file that browsers play,
``segmentation`` says what is where in the first frame, ``items`` does all of this for one
recording, and ``batch`` for many.
"""
