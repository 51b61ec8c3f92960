"""How kernels of concentric tubes are compiled.

Reordered sums cost the last digit and nothing else; numbers that are none stay so. What only other
kernels call needs no entrance from Python, which would take as long to compile as the kernel.
"""

OUTER = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "reassoc", "nsz"},
}
INNER = {**OUTER, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# Numbers in lanes would go through memory at each call.
INSIDE = {**INNER, "forceinline": True}
# Where a sum's order is what makes it exact.
EXACT = {**INSIDE, "fastmath": {"contract"}}
