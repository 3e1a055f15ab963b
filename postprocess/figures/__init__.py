"""Figures of pages as SVG text, written directly (`svg`); plots, animations and pictures by matplotlib."""
