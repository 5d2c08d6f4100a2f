"""Generated scenarios: drawn at random and checked like all others."""
