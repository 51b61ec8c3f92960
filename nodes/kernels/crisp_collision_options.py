"""How kernels of collision checking are compiled.

A call that hands on a grid, which is four arrays, takes longer than most of what is called: all but
the largest functions are inlined.
"""

from nodes.kernels.crisp_options import INNER, OUTER

__all__ = ["INNER", "INSIDE", "OUTER"]

INSIDE = {**INNER, "forceinline": True}
