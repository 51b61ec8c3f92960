"""Arrays without reference counts: counting is an atomic operation, and kernels would do hundreds.

The caller of the kernel holds the arrays until it returns.
"""

from numba import carray, njit, types
from numba.extending import intrinsic

from nodes.kernels.ctr_options import INNER


@intrinsic
def _as_pointer(typing, address):
    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(types.voidptr))

    return types.voidptr(address), generate


@njit(**INNER)
def borrow(array):
    """Return the same C-contiguous array without a reference to its memory."""
    return carray(_as_pointer(array.ctypes.data), array.shape, array.dtype)
