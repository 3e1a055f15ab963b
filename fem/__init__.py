"""The finite-element plate: scikit-fem supplies elements, quadrature and matrices; the time loop is compiled.

The package stands alone: it knows neither the rigid-body solution that it is compared with nor scene files.
"""
