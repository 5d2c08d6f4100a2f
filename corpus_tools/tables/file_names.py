"""Names of files as other systems write them."""

from __future__ import annotations

import os
import re
import unicodedata
from pathlib import Path, PureWindowsPath

_SHADOW = re.compile(
    r"\._.*|\.DS_Store|\.AppleDouble|\.Trashes|\.Spotlight-V100|\.fseventsd|__MACOSX|Icon\r"
    r"|~\$.*|Thumbs\.db|ehthumbs(_vista)?\.db|desktop\.ini|\$RECYCLE\.BIN|System Volume Information"
    r"|\.~lock\..*#|\.directory|\.Trash-\d+|@eaDir|lost\+found",
    re.IGNORECASE,
)


def normal_name(name: str) -> str:
    """Return a name in the form in which names are compared (Unicode's NFC).

    Systems store the letters with accents in file names in two ways.
    """
    return unicodedata.normalize("NFC", name)


def is_shadow(path: Path) -> bool:
    """Check that another system has put a file, or a folder around it, beside people's files."""
    return any(_SHADOW.fullmatch(part) for part in path.parts)


def find_file(folder: Path, name: str) -> Path:
    """Return the path of a file that a table names.

    Parameters
    ----------
    folder
        The folder in which relative names begin.
    name
        The name as the table has it. Accents may be stored in another way than on the disk, and
        folders may be separated as on Windows.

    Returns
    -------
    Path
        The file that is there, else the path in `folder` that the name stands for.
    """
    path = folder / name
    if os.path.exists(path):  # noqa: PTH110 - a name may be too long for a Path's own method
        return path
    names = [name, PureWindowsPath(name).as_posix()] if "\\" in name else [name]
    spelled = (_as_on_disk(folder / one) for one in names)
    return next((one for one in spelled if one is not None), path)


def _as_on_disk(path: Path) -> Path | None:
    reached = Path(path.anchor)
    for part in path.parts[len(reached.parts) :]:
        following = reached / part
        if not os.path.exists(following):  # noqa: PTH110 - as above
            try:
                same = (p for p in reached.iterdir() if normal_name(p.name) == normal_name(part))
                following = min(same)
            except (OSError, ValueError):
                return None
        reached = following
    return reached
