"""Run the command line as `python -m tailslap`."""

from tailslap import cli

cli.main()
