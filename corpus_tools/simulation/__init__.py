"""Simulated workers: commands and ratings for load, scale and power studies.

Nothing here stands for what people say or think; all that is made is labelled *simulated*.
"""
