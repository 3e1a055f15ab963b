"""Forwards to `tailslap.campaign.engine`."""

from tailslap.campaign.engine import run_parts

__all__ = ["run_parts"]
