"""`tailslap modes`: natural frequencies and shapes of the free plate in its plane, beside beam theory."""
