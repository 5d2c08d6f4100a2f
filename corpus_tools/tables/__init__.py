"""The reader of other people's tables: CSV, JSON lines and JSON, with a place in every error."""
