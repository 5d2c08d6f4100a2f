"""Words in their normal form, the concepts that they name, and classes of verbs."""
