"""Forwards to `tailslap.campaign.records`."""

from tailslap.campaign.records import Journal

__all__ = ["Journal"]
