"""Page that computes whole impacts in a browser."""
