"""What a run says: text on the terminal, summary, page."""
