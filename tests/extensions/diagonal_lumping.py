"""A lumping from outside, the scaled diagonal of the consistent matrix."""

from fem import LUMPINGS, Lumping
from fem.plate.nodal_masses import scaled_diagonal_masses

LUMPING = Lumping("diagonal", scaled_diagonal_masses, fault="it is that of the scaled diagonal")
LUMPINGS.register(LUMPING)
