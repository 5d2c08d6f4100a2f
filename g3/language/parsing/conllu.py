"""Analysed commands as CoNLL-U: Universal Dependencies, and the clause that each word is in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from unicodedata import normalize

from g3.language.parsing.spacy_pipeline import Analysis, language_model
from g3.language.parsing.universal_dependencies import universal_words
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import has_implicit_figure


def to_conllu(
    command: Analysis,
    sdcs: Sequence[SDC],
    *,
    sent_id: str,
    comments: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Write a command's words as valid Universal Dependencies, with the clauses that they are in.

    The columns are those of CoNLL-U. XPOS has spaCy's parts of speech (Penn Treebank); FEATS is
    empty. MISC has the clause and the field that the word is in, such as ``SDC=PLACE_3.r``, with
    the numbers that the bracket notation gives.

    Parameters
    ----------
    command
        The analysed command.
    sdcs
        Its top-level clauses.
    sent_id
        What the sentence is called, unique in its file; a "/" in it becomes "_".
    comments
        Further comments, by their names.

    Returns
    -------
    str
        The sentence, without the empty line after it; empty if the command has no words.
    """
    if not command.spans:
        return ""
    strings = language_model().vocab.strings
    clauses = _clause_of_characters(sdcs)
    text, rows = "", []
    following = [*(span.start for span in command.spans[1:]), command.spans[-1].end]
    for i, (span, word, after) in enumerate(
        zip(command.spans, universal_words(command), following, strict=True)
    ):
        is_last = i == len(command.spans) - 1
        form = normalize("NFC", span.text)
        text += form if after == span.end else f"{form} "
        clause = next((clauses[c] for c in range(span.start, span.end) if c in clauses), None)
        misc = [] if clause is None else [f"SDC={clause}"]
        misc += ["SpaceAfter=No"] if after == span.end and not is_last else []
        columns = (
            str(i + 1),
            form,
            word.lemma,
            word.upos,
            strings[int(command.tag[i])] or "_",
            "_",
            "0" if word.head is None else str(word.head + 1),
            word.relation,
            "_",
            "|".join(misc) or "_",
        )
        rows.append("\t".join(columns))
    told = {"sent_id": sent_id.replace("/", "_"), "text": text, **comments}
    head = [f"# {name} = {value}" for name, value in told.items()]
    return "\n".join([*head, *rows, ""])


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
