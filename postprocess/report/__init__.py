"""Reports: a table declared once goes to terminal, page and files; one page template; what a command leaves and says."""
