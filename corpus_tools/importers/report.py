"""Report of an import: the records read, and those left out with the reasons."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

import msgspec

from g3.errors import FormatError
from g3.short_repr import short_repr

REPORT = "import-report.json"


class Skipped(msgspec.Struct, frozen=True):
    """A record that could not be read; the whole file if `record` is empty."""

    file: str
    record: str
    field: str
    reason: str
    fix: str

    def error(self) -> FormatError:
        """Return the problem as an error."""
        where = ": ".join(part for part in (self.file, self.record, self.field) if part)
        return FormatError(self.reason, where=where, fix=self.fix)


@short_repr
class Note(msgspec.Struct, frozen=True):
    """Something unusual that was read all the same, and the records that have it."""

    what: str
    records: tuple[str, ...]


class SourceFile(msgspec.Struct, frozen=True):
    """A file that was read."""

    file: str
    sha256: str
    records: int


@short_repr
class ImportReport(msgspec.Struct, frozen=True):
    """The file import-report.json."""

    importer: str
    counts: dict[str, int]
    skipped: tuple[Skipped, ...]
    notes: tuple[Note, ...]
    not_imported: dict[str, int]
    """Kinds of files that are there but not read, and how many."""
    missing: tuple[str, ...]
    """Files that the source may have and this one doesn't."""
    files: tuple[SourceFile, ...]
    parts_there: tuple[str, ...] = ()
    """Parts of the source that were found, for sources that have parts."""
    parts_taken: tuple[str, ...] = ()
    """Parts that were imported."""

    def to_bytes(self) -> bytes:
        """Return the file's content."""
        return msgspec.json.format(msgspec.json.encode(self), indent=2) + b"\n"


@short_repr
@dataclass(slots=True)
class Journal:
    """Problems and files that an importer has met."""

    keep_going: bool
    skipped: list[Skipped] = field(default_factory=list)
    files: list[SourceFile] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    notes: dict[str, list[str]] = field(default_factory=lambda: defaultdict(list))

    def skip(self, file: str, record: str, error: FormatError) -> None:
        """Note a record that can't be read; the error's ``where`` is its field."""
        self.skipped.append(Skipped(file, record, error.where, error.what, error.fix))

    def note(self, what: str, record: str) -> None:
        """Note something unusual about a record that was read."""
        self.notes[what].append(record)

    def check(self) -> None:
        """Raise the first problem, a FormatError, unless the import shall keep going."""
        if self.keep_going or not self.skipped:
            return
        first = self.skipped[0].error()
        others = len(self.skipped) - 1
        more = f"; {others} more records can't be read" if others else ""
        fix = f"{first.fix}; " if first.fix else ""
        raise FormatError(
            first.what,
            where=first.where,
            fix=f"{fix}--keep-going imports the rest{more}",
        )

    def report(
        self, importer: str, counts: dict[str, int], not_imported: dict[str, int]
    ) -> ImportReport:
        """Sum up."""
        return ImportReport(
            importer=importer,
            counts=counts,
            skipped=tuple(self.skipped),
            notes=tuple(Note(what, tuple(records)) for what, records in self.notes.items()),
            not_imported=not_imported,
            missing=tuple(self.missing),
            files=tuple(self.files),
        )
