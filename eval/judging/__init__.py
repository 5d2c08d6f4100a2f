"""The automatic judge of plans, and how far it agrees with people."""
