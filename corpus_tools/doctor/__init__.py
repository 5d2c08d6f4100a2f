"""``ct doctor``: missing parts of this machine, and how to get them."""
