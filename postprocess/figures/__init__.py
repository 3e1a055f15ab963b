"""Figures of pages as charts of marks."""
