"""Registration with ``ct import``; imports nothing that is heavy."""

from corpus_tools.importers.importer_registry import Importer, register

register(
    Importer(
        name="tabletop-blocks",
        summary="Coloured blocks on a table, made by a program.",
        description="PATH is a JSON file: how many tables, how many commands for each, and a seed.",
        target="tabletop_blocks.importer:import_blocks",
    )
)
