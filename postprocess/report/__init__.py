"""Reports: a table declared once, one page, and what a command leaves and says."""
