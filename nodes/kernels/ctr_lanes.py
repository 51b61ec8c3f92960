"""Lanes: eight numbers that go through the same arithmetic at once, one for each step of a robot.

Inside kernels lanes add, subtract, multiply and divide like a float, with others and with floats.
Eight are one register of the widest vector units; a robot seldom has more steps.
"""

import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

LANES = 8
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_FUSED = ("contract",)  # a * b + c may be rounded once
_PAGE, _LINE, _APART = 512, 8, 56  # floats: a page of 4 kB, a line of cache, seven of them


def make_rooms(*shapes: tuple[int, ...]) -> list[np.ndarray]:
    """Return arrays, not filled, whose beginnings lie apart within pages, on cache lines.

    A processor may take a load for one of a recent store where their last twelve bits agree. That
    this slows the kernels has not been shown; it costs nothing to rule it out.
    """
    sizes = [int(np.prod(shape)) for shape in shapes]
    starts, start = [], 0
    for size in sizes:
        starts.append(start)
        start += -(-size // _PAGE) * _PAGE + min(-(-size // _LINE) * _LINE, _APART)
    raw = np.empty(start + _PAGE)
    skipped = -(raw.ctypes.data // 8) % _PAGE
    return [
        raw[skipped + start : skipped + start + size].reshape(shape)
        for start, size, shape in zip(starts, sizes, shapes, strict=True)
    ]


def make_steps(rows: int) -> np.ndarray:
    """Return an array (rows, LANES), not filled, that begins with a cache line, for speed."""
    return make_rooms((rows, LANES))[0]


class _LanesType(types.Type):
    def __init__(self):
        super().__init__(name="EightLanes")


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


def _everywhere(builder, number):
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    mask = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, nothing, mask)


@intrinsic
def load_rows(typing_context, like, array, row):
    """Return rows `row`, `row` + 1, ... of an array (rows, LANES), as many as `like` is long."""

    def generate(context, builder, signature, arguments):
        values = []
        for i in range(like.count):
            at = builder.add(arguments[2], ir.Constant(arguments[2].type, i))
            value = builder.load(_row(context, builder, array, arguments[1], at))
            value.align = 8
            values.append(value)
        return context.make_tuple(builder, signature.return_type, values)

    return types.UniTuple(_lanes, like.count)(like, array, types.intp), generate


@intrinsic
def store_rows(typing_context, values, array, row):
    """Write a tuple of lanes to rows `row`, `row` + 1, ... of an array (rows, LANES)."""

    def generate(context, builder, signature, arguments):
        for i in range(values.count):
            at = builder.add(arguments[2], ir.Constant(arguments[2].type, i))
            value = builder.extract_value(arguments[0], i)
            builder.store(value, _row(context, builder, array, arguments[1], at)).align = 8
        return context.get_dummy_value()

    return types.void(values, array, types.intp), generate


@intrinsic
def store_points(typing_context, x, y, z, array, first):
    """Write eight points to rows `first`, ... of a C-contiguous array (rows, 3)."""

    def generate(context, builder, signature, arguments):
        x, y, z, values, first = arguments
        number = ir.IntType(32)

        def mix(left, right, order):
            mask = ir.Constant(ir.VectorType(number, len(order)), order)
            return builder.shuffle_vector(left, right, mask)

        pairs = mix(x, y, list(range(2 * LANES)))
        more = mix(z, z, list(range(LANES)) + [0] * LANES)
        order = [axis * LANES + i for i in range(LANES) for axis in range(3)]
        mixed = mix(pairs, more, order)
        data = context.make_array(array)(context, builder, values).data
        start = builder.gep(data, [builder.mul(first, ir.Constant(first.type, 3))])
        builder.store(mixed, builder.bitcast(start, ir.PointerType(mixed.type))).align = 8
        return context.get_dummy_value()

    return types.void(_lanes, _lanes, _lanes, array, types.intp), generate


@intrinsic
def spread_rows(typing_context, like, number):
    """Return a tuple as long as `like` of lanes that all hold one float."""

    def generate(context, builder, signature, arguments):
        value = _everywhere(builder, arguments[1])
        return context.make_tuple(builder, signature.return_type, [value] * like.count)

    return types.UniTuple(_lanes, like.count)(like, types.float64), generate


@intrinsic
def spread(typing_context, number):
    """Return lanes that all hold one float."""

    def generate(context, builder, signature, arguments):
        return _everywhere(builder, arguments[0])

    return _lanes(types.float64), generate


@intrinsic
def count_up(typing_context, first):
    """Return first, first + 1, ..."""

    def generate(context, builder, signature, arguments):
        same = _everywhere(builder, arguments[0])
        return builder.fadd(same, ir.Constant(_VECTOR, [float(i) for i in range(LANES)]))

    return _lanes(types.float64), generate


@intrinsic
def nearest(typing_context, value):
    """Return the nearest whole number of a float or of lanes."""

    def generate(context, builder, signature, arguments):
        kind = arguments[0].type
        name = f"llvm.rint.v{LANES}f64" if kind == _VECTOR else "llvm.rint.f64"
        rint = get_or_insert_function(builder.module, ir.FunctionType(kind, [kind]), name)
        return builder.call(rint, arguments)

    return value(value), generate


@intrinsic
def turn_quarters(typing_context, quarters, sine, cosine):
    """Return sine and cosine of an angle that is larger by some quarter turns; floats or lanes."""

    def generate(context, builder, signature, arguments):
        quarters, sine, cosine = arguments
        whole = ir.IntType(64)
        is_vector = quarters.type == _VECTOR
        kind = ir.VectorType(whole, LANES) if is_vector else whole

        def constant(number):
            return ir.Constant(kind, [number] * LANES if is_vector else number)

        def negate_by(bit, value):
            sign = builder.shl(builder.and_(bit, constant(2)), constant(62))
            return builder.bitcast(builder.xor(builder.bitcast(value, kind), sign), quarters.type)

        turns = builder.fptosi(quarters, kind)
        is_odd = builder.icmp_signed("!=", builder.and_(turns, constant(1)), constant(0))
        one = negate_by(turns, builder.select(is_odd, cosine, sine))
        turns = builder.add(turns, constant(1))
        other = negate_by(turns, builder.select(is_odd, sine, cosine))
        return context.make_tuple(builder, signature.return_type, [one, other])

    return types.UniTuple(quarters, 2)(quarters, quarters, quarters), generate


@intrinsic
def choose_less(typing_context, left, right, one, other):
    """Return one where left < right, else other."""

    def generate(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered("<", *arguments[:2]), *arguments[2:])

    return _lanes(_lanes, _lanes, _lanes, _lanes), generate


@intrinsic
def is_any_less(typing_context, left, right):
    """Return whether left < right in any lane; what is no number is not."""

    def generate(context, builder, signature, arguments):
        truth = builder.bitcast(builder.fcmp_ordered("<", *arguments), ir.IntType(LANES))
        return builder.icmp_unsigned("!=", truth, ir.Constant(truth.type, 0))

    return types.boolean(_lanes, _lanes), generate


def _add_operator(operation, emit):
    """Let an operator take lanes with lanes and with floats; compiled where it stands, no call."""

    @type_callable(operation)
    def type_operands(context):
        def give_type(left, right):
            numbers = types.Float, types.Integer
            if left is _lanes and (right is _lanes or isinstance(right, numbers)):
                return _lanes
            return _lanes if right is _lanes and isinstance(left, numbers) else None

        return give_type

    def widen(context, builder, kind, value):
        if kind is _lanes:
            return value
        return _everywhere(builder, context.cast(builder, value, kind, types.float64))

    def generate(context, builder, signature, arguments):
        pair = zip(signature.args, arguments, strict=True)
        left, right = (widen(context, builder, kind, value) for kind, value in pair)
        return emit(builder, left, right, flags=_FUSED)

    for kinds in ((_lanes, _lanes), (_lanes, types.Number), (types.Number, _lanes)):
        lower_builtin(operation, *kinds)(generate)


for _operators, _emit in (
    ((operator.add, operator.iadd), ir.IRBuilder.fadd),
    ((operator.sub, operator.isub), ir.IRBuilder.fsub),
    ((operator.mul,), ir.IRBuilder.fmul),
    ((operator.truediv,), ir.IRBuilder.fdiv),
):
    for _operation in _operators:
        _add_operator(_operation, _emit)


@type_callable(operator.neg)
def _type_negative(context):
    return lambda value: _lanes if value is _lanes else None


@lower_builtin(operator.neg, _lanes)
def _negate(context, builder, signature, arguments):
    return builder.fneg(arguments[0])
