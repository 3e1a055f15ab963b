"""The deformed plate at the first instant: inertia relief, linear and at finite strain."""
