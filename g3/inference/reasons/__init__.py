"""Why things and actions were chosen, in plain words."""
