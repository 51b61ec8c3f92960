"""Shared words: frames, grids, meshes and point clouds, and where each product comes from."""
