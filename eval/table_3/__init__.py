"""Table 3: plans for commands of held-out scenarios."""
