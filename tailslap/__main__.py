"""`python -m tailslap`: the command line."""

from tailslap.cli import main

main()
