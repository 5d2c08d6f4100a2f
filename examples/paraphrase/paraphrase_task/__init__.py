"""Paraphrase: a task of the annotation app in which people say a command in other words."""
