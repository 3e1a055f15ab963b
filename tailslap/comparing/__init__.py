"""`tailslap compare`: results of this program, and histories of others, side by side."""
