"""What is given of a law's parameters before a fit, in lmfit's words, and the arithmetic that ties them.

Only a text that `arithmetic` let pass by its syntax tree may reach lmfit.
"""

import ast
import keyword
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from freerock.errors import FreerockError
from freerock.models.free_parameters import LOGARITHMS, PARAMETERS
from freerock.models.laws import LAWS

LONGEST = 200  # characters of an expression
OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)
REMEDY = "use names of the law's other parameters, numbers, + - * / ** and brackets"


@dataclass(frozen=True)
class Given:
    """What is given of one parameter [SI].

    Parameters
    ----------
    value : float or None
        That it has, where it does not vary; else a value from which the search may start, beside its own.
    min, max : float or None
        Bounds of the fit.
    vary : bool
        False fixes it at `value`.
    expr : str
        Arithmetic of other parameters' names, which ties it to these.
    """

    value: float | None = None
    min: float | None = None
    max: float | None = None
    vary: bool = True
    expr: str = ""

    @property
    def varies(self) -> bool:
        """Whether a fit finds it."""
        return self.vary and not self.expr


def legal(name: str) -> str:
    """A parameter's name as Python, and so lmfit, allows it: `lambda_` for lambda."""
    return f"{name}_" if keyword.iskeyword(name) else name


def arithmetic(text: str, names: Mapping[str, Any] | tuple[str, ...]) -> str:
    """The text of an expression as lmfit takes it, once nothing but arithmetic is found in it.

    Parameters
    ----------
    text : str
    names : iterable of str
        Parameters that it may name; lambda as such or as lambda_.

    Raises
    ------
    FreerockError
        It holds anything but these names, numbers, + - * / ** and unary minus, or is no finite number where
        all of them are 1.
    """
    tree = _tree(text)
    unknown = names_in(text) - {legal(name) for name in names}
    if unknown:
        raise _refused(text, f"{min(unknown)!r} is not another parameter of the law")
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant):
            node.value = float(node.value)  # type: ignore[arg-type]  # whose powers overflow at once
    try:
        code = compile(ast.Expression(tree), "expr", "eval")
        value = float(eval(code, {"__builtins__": {}}, dict.fromkeys(map(legal, names), 1.0)))
    except (ArithmeticError, TypeError, RecursionError):  # a root of a negative number is complex
        value = math.nan
    if not math.isfinite(value):
        raise _refused(text, "is no finite number")
    return _spelt(text)


def names_in(text: str) -> set[str]:
    """Names in an expression, as lmfit allows them."""
    return {node.id for node in ast.walk(_tree(text)) if isinstance(node, ast.Name)}


def faults(law: str, given: Mapping[str, Given]) -> Iterator[tuple[str, str, str]]:
    """What is wrong with what is given of a law's parameters: parameter, what, and what to do."""
    names = LAWS[law].parameters
    for name, each in given.items():
        if name not in names:
            yield name, f"is not a parameter of {law}", f"use {' or '.join(names)}"
            return
        yield from ((name, *fault) for fault in _faults_of_one(name, each))
        if each.expr:
            try:
                arithmetic(each.expr, tuple(other for other in names if other != name))
            except FreerockError as error:
                yield name, error.what, error.remedy
                return
    left = {name for name in given if given[name].expr}
    while free := {name for name in left if not names_in(given[name].expr) & {*map(legal, left)}}:
        left -= free
    if left:
        yield min(left), "is tied in a circle", "free or fix one of them"


def _faults_of_one(name: str, given: Given) -> Iterator[tuple[str, str]]:
    numbers = {key: getattr(given, key) for key in ("value", "min", "max")}
    if given.expr and (not given.vary or any(number is not None for number in numbers.values())):
        yield "has an expr and more", "leave out value, min, max and vary, or expr"
    if not given.expr and not given.vary and given.value is None:
        yield "does not vary and has no value", "give its value"
    low, high = PARAMETERS[name].bounds if PARAMETERS[name].fitted_as != "ratio" else (0.0, math.inf)
    for key, number in numbers.items():
        if number is not None and not low <= number <= high:
            yield f"{key} is {number:g}", f"give {low:g} to {high:g}"
        elif number == 0 and PARAMETERS[name].fitted_as in LOGARITHMS:
            yield f"{key} is 0", "give a value above 0" if key == "value" else "leave it out"
    least = -math.inf if given.min is None else given.min
    most = math.inf if given.max is None else given.max
    if not least < most:
        yield f"min {least:g} is not below max {most:g}", "correct one of the two"
    elif given.value is not None and not least <= given.value <= most:
        yield f"value {given.value:g} is not between min and max", "correct one of them"


def _spelt(text: str) -> str:
    """An expression with names as lmfit allows them."""
    return re.sub(r"\blambda\b", legal("lambda"), text.strip())


def _tree(text: str) -> ast.expr:
    if not re.fullmatch(r"[A-Za-z0-9_ .+*/()-]*", text):
        raise _refused(text, "is no arithmetic")
    if len(text) > LONGEST:
        raise _refused(text, f"has {len(text)} characters, more than {LONGEST}")
    try:
        tree = ast.parse(_spelt(text), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise _refused(text, "is no arithmetic") from None
    for node in ast.walk(tree):
        fine = isinstance(node, ast.Name | ast.Load | ast.USub | ast.operator | ast.BinOp | ast.UnaryOp)
        fine = fine or (isinstance(node, ast.Constant) and type(node.value) in (int, float))
        if not fine or (isinstance(node, ast.operator) and not isinstance(node, OPERATORS)):
            raise _refused(text, "is no arithmetic")
    return tree


def _refused(text: str, what: str) -> FreerockError:
    return FreerockError("fits.parameters", f"expr {text[:60]!r} {what}", REMEDY)
