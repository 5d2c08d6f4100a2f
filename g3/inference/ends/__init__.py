"""Where a command's words, without their trees, say that each load ends."""
