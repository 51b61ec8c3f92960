"""How kernels of CRISP robots are compiled.

What only other kernels call needs no entrance from Python, which would take as long to compile as a
small kernel. Numba compiles a function again for each literal number that it is called with: 0 is
written np.int64(0) where a variable is passed elsewhere.
"""

OUTER = {"cache": True, "nogil": True, "error_model": "numpy"}
INNER = {**OUTER, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
