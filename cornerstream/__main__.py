"""``python -m cornerstream``."""

from cornerstream.cli import main

main(prog_name="cornerstream")
