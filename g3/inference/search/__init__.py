"""The two passes of the search: OBJECTs and PLACEs, then actions (section 3.4)."""
