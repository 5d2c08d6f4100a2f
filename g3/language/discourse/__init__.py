"""What pronouns, negation and plurals mean within a command."""
