"""The tasks that people do: items leased, shown, answered, checked, and made into the next task."""
