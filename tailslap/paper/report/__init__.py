"""The review as tables, findings and a page."""
