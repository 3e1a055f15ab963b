"""Figures of pages as SVG text (`svg`); plots of results in Python and animations by matplotlib."""
