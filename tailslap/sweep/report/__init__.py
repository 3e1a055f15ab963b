"""What it says: text, tables, page."""
