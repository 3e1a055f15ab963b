"""Two motions set side by side: differences, error measures, orders of convergence."""
