"""Files written wholly or not at all, by one writer at a time, and checked arrays."""
