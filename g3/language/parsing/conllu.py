"""Analysed commands in the CoNLL-U format, with the clause that each word is in."""

from __future__ import annotations

from collections.abc import Sequence

from g3.language.parsing.spacy_pipeline import Analysis, language_model
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import has_implicit_figure


def to_conllu(command: Analysis, sdcs: Sequence[SDC]) -> str:
    """Write a command's words with parts of speech, dependencies and clauses.

    The column XPOS has spaCy's parts of speech (Penn Treebank), DEPREL its dependencies
    (ClearNLP). MISC has the clause and the field that the word is in, such as
    ``SDC=PLACE_3.r``, with the numbers that the bracket notation gives. LEMMA, UPOS and FEATS
    are empty, for nothing here determines them.

    Parameters
    ----------
    command
        The analysed command.
    sdcs
        Its top-level clauses.
    """
    strings = language_model().vocab.strings
    clauses = _clause_of_characters(sdcs)
    text = " ".join(command.text.split())
    lines = [f"# text = {text}"]
    heads = command.head.tolist()
    for i, span in enumerate(command.spans):
        root = heads[i] == i
        dep = "root" if root else strings[int(command.dep[i])].lower() or "dep"
        after = command.spans[i + 1].start if i + 1 < len(command.spans) else span.end + 1
        clause = next((clauses[c] for c in range(span.start, span.end) if c in clauses), None)
        misc = [] if clause is None else [f"SDC={clause}"]
        misc += ["SpaceAfter=No"] if after == span.end else []
        columns = (
            str(i + 1),
            span.text,
            "_",
            "_",
            strings[int(command.tag[i])] or "_",
            "_",
            "0" if root else str(heads[i] + 1),
            dep,
            "_",
            "|".join(misc) or "_",
        )
        lines.append("\t".join(columns))
    return "\n".join([*lines, ""])


def _clause_of_characters(sdcs: Sequence[SDC]) -> dict[int, str]:
    # Annotators' words may be cut otherwise than the parser's.
    found: dict[int, str] = {}
    number = 0

    def visit(sdc: SDC) -> None:
        nonlocal number
        number += 1
        name = f"{sdc.type}_{number}"
        for field, spans in (("f", sdc.words), ("r", sdc.relation)):
            for span in spans:
                found.update(dict.fromkeys(range(span.start, span.end), f"{name}.{field}"))
        children = sdc.children()[1:] if has_implicit_figure(sdc) else sdc.children()
        for child in children:
            visit(child)

    for sdc in sdcs:
        visit(sdc)
    return found
