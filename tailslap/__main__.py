"""`python -m tailslap`: the command line."""

from tailslap import cli

cli.main()
