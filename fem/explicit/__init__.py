"""Time: internal forces in blocks of elements, the compiled step on one thread or several, and what is measured."""
