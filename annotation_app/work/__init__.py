"""What is the same for all tasks: handing items out, reading answers, and going on with them."""
