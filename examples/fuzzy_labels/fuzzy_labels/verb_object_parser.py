"""A parser for which a command is a verb and a thing."""

import re

from eval.parsing.parser_registry import parser
from g3.sdc.clauses import SDC, Span


@parser("verb-object")
def verb_object(text: str) -> tuple[SDC, ...]:
    """Take the first word as what to do, and all others as one thing."""
    verb, *thing = (Span(match.start(), match[0]) for match in re.finditer(r"\w+", text))
    landmark = (SDC("OBJECT", words=tuple(thing)),) if thing else ()
    return (SDC("EVENT", relation=(verb,), figure=(SDC("OBJECT"),), landmark1=landmark),)
