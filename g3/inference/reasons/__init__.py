"""Reasons for chosen things and actions, in plain words."""
