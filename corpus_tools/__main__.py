"""``python -m corpus_tools`` is the console script ``ct``."""

from corpus_tools.cli.console import main

if __name__ == "__main__":
    main()
