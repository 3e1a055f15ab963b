"""Whether a run is right: checks, numerical error, verdict."""
