"""``ct eval --report``: everything that is measured, on one page and in files beside it."""
