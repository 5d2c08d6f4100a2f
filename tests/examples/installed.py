"""Examples installed beside the toolkit, as pip does it."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
CT = Path(sys.executable).with_name("ct")


@dataclass(frozen=True)
class Installed:
    """An example in a folder of its own, beside the toolkit."""

    folder: Path

    def ct(self, *args: str) -> subprocess.CompletedProcess[str]:
        """Run ``ct`` in the folder."""
        return self._run(CT, *args)

    def python(self, code: str, *args: str) -> subprocess.CompletedProcess[str]:
        """Run some Python in the folder."""
        return self._run(sys.executable, "-c", code, *args)

    def _run(self, *args: str | Path) -> subprocess.CompletedProcess[str]:
        env = {**os.environ, "PYTHONPATH": f"{self.folder / 'site'}{os.pathsep}{ROOT}"}
        return subprocess.run(
            args, check=False, capture_output=True, text=True, cwd=self.folder, env=env, timeout=300
        )


def install(example: str, folder: Path) -> Installed:
    """Install an example into a folder."""
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index"]
    target = ["--no-build-isolation", "--target", str(folder / "site")]
    subprocess.run([*pip, *target, str(EXAMPLES / example)], check=True, timeout=300)
    return Installed(folder)
