"""Robot episodes of several formats, as videos and tables for studies."""
