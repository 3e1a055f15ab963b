"""Materials: stress and energy density from the deformation gradient."""
