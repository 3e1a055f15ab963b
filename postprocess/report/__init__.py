"""Reports: tables declared once, the page, and the files and terminal text of a command."""
