"""Motions of needle-sized robots through free space: set-ups, trees, plans and their checks."""
