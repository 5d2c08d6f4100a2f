"""What long and careful work needs: processes, progress, whole folders, safe output."""
