"""What everything else needs: configuration, keys, ids, refusals."""
