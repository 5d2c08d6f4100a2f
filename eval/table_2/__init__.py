"""Table 2: how often people agree that a video shows a command."""
