"""State of a world at a moment: kinds of things, their sizes and shapes, scripts, recordings."""
