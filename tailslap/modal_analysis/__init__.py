"""The plate by its modes: `run` with a few of them (`tailslap modal`), free `modes` (`tailslap modes`)."""
