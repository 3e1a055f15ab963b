"""Parts of peers.py."""
