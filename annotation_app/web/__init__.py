"""What pages and programs share: the interface in JSON and its limits."""
