"""How often it is seen that something isn't there, and how often something is missed wrongly."""
