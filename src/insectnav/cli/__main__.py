"""``python -m insectnav.cli`` is the command ``insectnav``."""

from insectnav.cli import program

if __name__ == "__main__":
    program()
