"""The commands ``ct eval`` and ``ct demo``."""
