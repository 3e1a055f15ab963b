"""Strength of the parapet beside the force of the impact."""
