"""A kind of load that the toolkit doesn't have: a reel of cable on a pallet."""
