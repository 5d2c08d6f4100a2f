"""Hard negatives: wrong groundings that the robot might really consider for a command."""
