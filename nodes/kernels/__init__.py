"""Numba kernels: numbers in, numbers out; one algorithm a file. The nodes check, kernels trust."""
