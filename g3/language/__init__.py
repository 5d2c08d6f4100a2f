"""Words: their normal form, the words of an SDC's fields, and how like a label they are."""
