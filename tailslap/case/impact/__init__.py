"""Whole impact by the rigid vehicle and by the FE plate."""
