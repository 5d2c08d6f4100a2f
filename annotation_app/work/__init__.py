"""Work on items, common to all tasks: handing them out, reading answers, and acting on these."""
