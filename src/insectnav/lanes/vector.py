"""A numba type for one number in each of 16 trials, with arithmetic.

Kernels are written for one trial; each variable holds 16 of them and each operation is one SIMD instruction (or two
or four, whatever the processor has). Compared with loops over lanes, nothing depends on whether the compiler manages
to vectorise, and a trial's bits do not depend on which lane it sits in or on what its neighbours do.

Scalars mix freely with lanes and are rounded to the lanes' own precision, so ``0.5 * x`` stays single precision when
``x`` is.
"""

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

from insectnav.lanes import LANES


class LanesType(types.Type):
    """The numba type of 16 numbers of one scalar type."""

    def __init__(self, dtype: types.Number) -> None:
        self.dtype = dtype
        super().__init__(name=f"lanes({dtype})")

    @property
    def is_real(self) -> bool:
        """True for lanes of floating point numbers."""
        return isinstance(self.dtype, types.Float)


@register_model(LanesType)
class LanesModel(models.PrimitiveModel):
    """In memory and in registers: an LLVM vector."""

    def __init__(self, manager: Any, lanes_type: LanesType) -> None:
        element = manager.lookup(lanes_type.dtype).get_value_type()
        super().__init__(manager, lanes_type, ir.VectorType(element, LANES))


def _splat(context: Any, builder: Any, value: Any, value_type: types.Type, lanes_type: LanesType) -> Any:
    """One scalar in every lane; lanes pass through."""
    if isinstance(value_type, LanesType):
        return value
    scalar = context.cast(builder, value, value_type, lanes_type.dtype)
    vector_type = context.get_value_type(lanes_type)
    first = builder.insert_element(ir.Constant(vector_type, ir.Undefined), scalar, ir.Constant(ir.IntType(32), 0))
    order = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(first, ir.Constant(vector_type, ir.Undefined), order)


def _common_type(arguments: tuple[types.Type, ...]) -> LanesType | None:
    lanes = {argument for argument in arguments if isinstance(argument, LanesType)}
    scalars = [argument for argument in arguments if not isinstance(argument, LanesType)]
    if len(lanes) == 1 and all(isinstance(scalar, types.Number) for scalar in scalars):
        return lanes.pop()
    return None


def _add_operator(function: Callable, real: str | None, integer: str | None) -> None:
    """Teach numba ``function`` of two lanes, or of lanes and a scalar, as the named LLVM instructions."""

    @infer_global(function)
    class _Typing(AbstractTemplate):
        def generic(self, arguments: tuple[types.Type, ...], keywords: dict) -> Any:
            common = _common_type(arguments) if len(arguments) == 2 else None
            if common is not None and (real if common.is_real else integer):
                return signature(common, *arguments)
            return None

    def lower(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        instruction = getattr(builder, str(real if sig.return_type.is_real else integer))
        operands = (
            _splat(context, builder, value, kind, sig.return_type)
            for value, kind in zip(arguments, sig.args, strict=True)
        )
        return instruction(*operands)

    for pair in ((LanesType, LanesType), (LanesType, types.Number), (types.Number, LanesType)):
        lower_builtin(function, *pair)(lower)


_add_operator(operator.add, "fadd", "add")
_add_operator(operator.sub, "fsub", "sub")
_add_operator(operator.mul, "fmul", "mul")
_add_operator(operator.truediv, "fdiv", None)
_add_operator(operator.and_, None, "and_")
_add_operator(operator.or_, None, "or_")
_add_operator(operator.xor, None, "xor")
_add_operator(operator.lshift, None, "shl")
_add_operator(operator.rshift, None, "lshr")


@infer_global(operator.neg)
class _NegateTyping(AbstractTemplate):
    def generic(self, arguments: tuple[types.Type, ...], keywords: dict) -> Any:
        is_real_lanes = isinstance(arguments[0], LanesType) and arguments[0].is_real
        return signature(arguments[0], *arguments) if is_real_lanes else None


@lower_builtin(operator.neg, LanesType)
def _lower_negate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    return builder.fneg(arguments[0])


@intrinsic
def address(typing_context: Any, array: Any) -> Any:
    """Where the numbers of a C-contiguous array are; the caller keeps the array alive.

    Kernels hand addresses on, not arrays: numba counts references to an array at every call, which costs more than the
    arithmetic here.
    """

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return context.make_array(sig.args[0])(context, builder, arguments[0]).data

    return types.CPointer(array.dtype)(array), generate


def _row_pointer(context: Any, builder: Any, scalar_type: types.Number, start: Any, row: Any) -> Any:
    offset = builder.mul(row, ir.Constant(row.type, LANES))
    vector_type = ir.VectorType(context.get_data_type(scalar_type), LANES)
    return builder.bitcast(builder.gep(start, [offset]), vector_type.as_pointer()), vector_type


@intrinsic
def load(typing_context: Any, start: Any, row: Any) -> Any:
    """Row ``row`` of the array (rows, LANES) at the address ``start``. Bounds are the kernel's own business."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        pointer, vector_type = _row_pointer(context, builder, sig.args[0].dtype, *arguments)
        instruction = builder.load(pointer, typ=vector_type)
        instruction.align = start.dtype.bitwidth // 8
        return instruction

    return LanesType(start.dtype)(start, types.intp), generate


@intrinsic
def store(typing_context: Any, start: Any, row: Any, lanes: Any) -> Any:
    """Write lanes to row ``row`` of the array (rows, LANES) at ``start``; a scalar goes to every lane."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        start_value, row_value, value = arguments
        pointer, _ = _row_pointer(context, builder, sig.args[0].dtype, start_value, row_value)
        vector = _splat(context, builder, value, sig.args[2], LanesType(sig.args[0].dtype))
        builder.store(vector, pointer).align = start.dtype.bitwidth // 8
        return context.get_dummy_value()

    return types.void(start, types.intp, lanes), generate


@intrinsic
def fill(typing_context: Any, scalar: Any, like: Any) -> Any:
    """``scalar`` in every lane, in the precision of the lanes ``like``."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return _splat(context, builder, arguments[0], sig.args[0], sig.args[1])

    return like(scalar, like), generate


def _call_llvm(builder: Any, name: str, lanes_type: LanesType, operands: list) -> Any:
    vector_type = operands[0].type
    function_type = ir.FunctionType(vector_type, [vector_type] * len(operands))
    full_name = f"llvm.{name}.v{LANES}f{lanes_type.dtype.bitwidth}"
    return builder.call(cgutils.get_or_insert_function(builder.module, function_type, full_name), operands)


def _llvm_function(name: str, n_arguments: int) -> Any:
    """An LLVM vector intrinsic such as llvm.fma as a numba function; its scalar arguments go to every lane."""

    def typing(typing_context: Any, *arguments: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            lanes_type = sig.return_type
            operands = [_splat(context, builder, v, t, lanes_type) for v, t in zip(values, sig.args, strict=True)]
            return _call_llvm(builder, name, lanes_type, operands)

        return signature(_common_type(arguments), *arguments), generate

    if n_arguments == 1:
        return intrinsic(lambda context, x: typing(context, x))
    if n_arguments == 2:
        return intrinsic(lambda context, x, y: typing(context, x, y))
    return intrinsic(lambda context, x, y, z: typing(context, x, y, z))


fma = _llvm_function("fma", 3)  # x * y + z, rounded once, on every machine
square_root = _llvm_function("sqrt", 1)
floor = _llvm_function("floor", 1)
minimum = _llvm_function("minnum", 2)
maximum = _llvm_function("maxnum", 2)


@intrinsic
def horner(typing_context: Any, x: Any, coefficients: Any) -> Any:
    """coefficients[0] + coefficients[1] x + coefficients[2] x² + …, by fused multiply-adds."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes_type, tuple_type = sig.args
        values = [
            _splat(context, builder, builder.extract_value(arguments[1], i), tuple_type.dtype, lanes_type)
            for i in range(tuple_type.count)
        ]
        total = values[-1]
        for value in reversed(values[:-1]):
            total = _call_llvm(builder, "fma", lanes_type, [total, arguments[0], value])
        return total

    return x(x, coefficients), generate


@intrinsic
def as_bits(typing_context: Any, x: Any) -> Any:
    """The bit patterns of real lanes, as integers of the same width."""
    bits = LanesType(types.int32 if x.dtype == types.float32 else types.int64)

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], context.get_value_type(sig.return_type))

    return bits(x), generate


@intrinsic
def from_bits(typing_context: Any, bits: Any) -> Any:
    """Real lanes from their bit patterns."""
    real = LanesType(types.float32 if bits.dtype == types.int32 else types.float64)

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], context.get_value_type(sig.return_type))

    return real(bits), generate


@intrinsic
def to_real(typing_context: Any, integers: Any, like: Any) -> Any:
    """Signed values of integer lanes as numbers of the precision of ``like``."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.sitofp(arguments[0], context.get_value_type(sig.return_type))

    return like(integers, like), generate
