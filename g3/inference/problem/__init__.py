"""A command in a state: its clauses, its candidates, and what groundings cost."""
