"""The commands ``ct annotate`` and ``ct crowd``."""
