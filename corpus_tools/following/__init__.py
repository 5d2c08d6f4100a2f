"""Following commands in simulated worlds, with the bundled model; plans in words."""
