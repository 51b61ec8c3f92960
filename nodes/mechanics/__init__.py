"""Mechanics of needle-sized robots, offered to all later stages. Units mm, N, MPa, rad."""
