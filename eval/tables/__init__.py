"""Tables as text, CSV, JSON and LaTeX."""
