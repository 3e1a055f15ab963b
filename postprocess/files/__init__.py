"""Histories and summaries as CSV and JSON files."""
