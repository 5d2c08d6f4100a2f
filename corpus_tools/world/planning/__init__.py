"""Ways around obstacles, without a simulator."""
