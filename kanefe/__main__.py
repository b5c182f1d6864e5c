"""``python -m kanefe``: the same as the command ``kanefe``."""

from kanefe.cli import main

if __name__ == "__main__":
    main()
