"""Lanes: sixteen numbers that go through the same arithmetic at once, one for each robot.

Inside kernels a `Lanes` adds, subtracts, multiplies and divides like a float, with others and with
floats, so code reads as if it were written for one robot; the machine's vector units do sixteen.
Plain loops over lanes are not vectorised reliably. Sixteen are two or four registers, so that one
operation needs not wait for the one before.
"""

import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, overload, register_model

LANES = 16
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_FUSED = ("contract",)  # a * b + c may be rounded once
_LINE = 64  # bytes of a cache line: loads that cross two take twice as long


def make_lanes(*shape: int) -> np.ndarray:
    """Return zeros (*shape, LANES) that begin with a cache line, for speed."""
    count = int(np.prod(shape)) * LANES
    raw = np.zeros(count + _LINE // 8)
    skipped = -(raw.ctypes.data // 8) % (_LINE // 8)
    return raw[skipped : skipped + count].reshape(*shape, LANES)


class _LanesType(types.Type):
    def __init__(self):
        super().__init__(name="Lanes")


_lanes = _LanesType()


@register_model(_LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _VECTOR)


def _row(context, builder, array_type, array, row):
    """Return the address of a row of a C-contiguous array (rows, LANES)."""
    data = context.make_array(array_type)(context, builder, array).data
    start = builder.mul(row, ir.Constant(row.type, LANES))
    return builder.bitcast(builder.gep(data, [start]), ir.PointerType(_VECTOR))


@intrinsic
def load(typing_context, array, row):
    """Return row `row` of a C-contiguous array (rows, LANES) of float64."""

    def generate(context, builder, signature, arguments):
        value = builder.load(_row(context, builder, signature.args[0], *arguments))
        value.align = 8
        return value

    return _lanes(array, types.intp), generate


@intrinsic
def store(typing_context, array, row, value):
    """Write lanes to row `row` of an array (rows, LANES)."""

    def generate(context, builder, signature, arguments):
        place = _row(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], place).align = 8
        return context.get_dummy_value()

    return types.void(array, types.intp, _lanes), generate


@intrinsic
def spread(typing_context, number):
    """Return lanes that all hold one float."""

    def generate(context, builder, signature, arguments):
        nothing = ir.Constant(_VECTOR, ir.Undefined)
        first = ir.Constant(ir.IntType(32), 0)
        one = builder.insert_element(nothing, arguments[0], first)
        everywhere = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return builder.shuffle_vector(one, nothing, everywhere)

    return _lanes(types.float64), generate


@intrinsic
def absolute(typing_context, value):
    """Return magnitudes; nan stays nan."""

    def generate(context, builder, signature, arguments):
        value = arguments[0]
        is_negative = builder.fcmp_ordered("<", value, ir.Constant(_VECTOR, [0.0] * LANES))
        return builder.select(is_negative, builder.fneg(value), value)

    return _lanes(_lanes), generate


@intrinsic
def is_less(typing_context, left, right):
    """Return 1 where left < right, else 0, also where either is nan."""

    def generate(context, builder, signature, arguments):
        truth = builder.fcmp_ordered("<", *arguments)
        return builder.select(
            truth, ir.Constant(_VECTOR, [1.0] * LANES), ir.Constant(_VECTOR, [0.0] * LANES)
        )

    return _lanes(_lanes, _lanes), generate


@intrinsic
def choose(typing_context, mask, left, right):
    """Return left where the mask is not 0, else right; what is not chosen may be nan."""

    def generate(context, builder, signature, arguments):
        mask, left, right = arguments
        zero = ir.Constant(_VECTOR, [0.0] * LANES)
        return builder.select(builder.fcmp_ordered("!=", mask, zero), left, right)

    return _lanes(_lanes, _lanes, _lanes), generate


@intrinsic
def is_any(typing_context, mask):
    """Return whether the mask is not 0 in any lane."""

    def generate(context, builder, signature, arguments):
        zero = ir.Constant(_VECTOR, [0.0] * LANES)
        truth = builder.fcmp_unordered("!=", arguments[0], zero)
        bits = builder.bitcast(truth, ir.IntType(LANES))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(_lanes), generate


def _make_operator(emit):
    """Return the overload of an operator for lanes with lanes and with floats."""

    @intrinsic
    def apply(typing_context, left, right):
        def generate(context, builder, signature, arguments):
            return emit(builder, *arguments)

        return _lanes(_lanes, _lanes), generate

    def choose_operands(left, right):
        numbers = types.Float, types.Integer
        if left is _lanes and right is _lanes:
            return lambda left, right: apply(left, right)
        if left is _lanes and isinstance(right, numbers):
            return lambda left, right: apply(left, spread(float(right)))
        if isinstance(left, numbers) and right is _lanes:
            return lambda left, right: apply(spread(float(left)), right)
        return None

    return choose_operands


overload(operator.add)(_make_operator(lambda builder, a, b: builder.fadd(a, b, flags=_FUSED)))
overload(operator.sub)(_make_operator(lambda builder, a, b: builder.fsub(a, b, flags=_FUSED)))
overload(operator.mul)(_make_operator(lambda builder, a, b: builder.fmul(a, b, flags=_FUSED)))
overload(operator.truediv)(_make_operator(lambda builder, a, b: builder.fdiv(a, b, flags=_FUSED)))
