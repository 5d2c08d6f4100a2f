"""Attentional vector sums: how far a point lies in a direction from a landmark."""
