"""The commands ``ct annotate``, ``ct publish`` and ``ct collect``."""
