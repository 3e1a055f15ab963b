"""From a scene to what is integrated: the rigid-body solution, then the FE model and what the program decides."""
