"""Free modes, beams to hold them against, and the modal model in a floating frame."""
