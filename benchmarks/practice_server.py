"""The practice pages of whatever version of the app can be imported, at a free port.

It runs as a script, with an empty folder as its argument, and prints the port.
"""

from __future__ import annotations

import logging
import sys
from dataclasses import replace
from pathlib import Path

from werkzeug.serving import make_server

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened
from annotation_app.store.schema import migrate


def main() -> None:
    """Serve until the process is ended."""
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    config = replace(open_instance(Path(sys.argv[1])), rate_limits=False)
    with opened(config.database) as engine:
        migrate(engine)
        server = make_server("127.0.0.1", 0, create_app(config, engine), threaded=True)
        sys.stdout.write(f"{server.server_port}\n")
        sys.stdout.flush()
        server.serve_forever()


if __name__ == "__main__":
    main()
