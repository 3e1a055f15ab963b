"""`python -m tailslap`: the command line."""

from tailslap.command_line import main

main()
