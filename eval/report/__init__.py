"""``ct eval report``: all measurements, on one page and in files beside it."""
