"""Numbers, limits and durations as a plan writes them, and what they mean. All are exact fractions."""

import decimal
from fractions import Fraction

MS = 1_000_000
# The integer types of a program, with their least and greatest values.
INTEGERS = {"SINT": (8, True), "USINT": (8, False), "BYTE": (8, False), "INT": (16, True), "UINT": (16, False),
            "WORD": (16, False), "DINT": (32, True), "UDINT": (32, False), "DWORD": (32, False), "LINT": (64, True),
            "ULINT": (64, False), "LWORD": (64, False)}


def bounds(kind):
    """The least and the greatest value of an integer type."""
    bits, signed = INTEGERS[kind]
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)


def shown(number):
    """The number that a real value is shown as: the shortest decimal that is no other one."""
    return Fraction(decimal.Decimal(repr(number)))


def text(number):
    """A fraction as a decimal; it has to be one."""
    if number.denominator == 1:
        return str(number.numerator)
    places = 0
    while (number * 10 ** places).denominator != 1:
        places += 1
        assert places < 30, number
    whole = abs(number * 10 ** places).numerator
    digits = str(whole).rjust(places + 1, "0")
    return f"{'-' if number < 0 else ''}{digits[:-places]}.{digits[-places:]}"


def rounded(number, places):
    """A decimal of some places near a fraction."""
    return Fraction(round(number * 10 ** places), 10 ** places)


def duration(ns):
    """A duration as a plan writes it."""
    for unit, size in (("ms", MS), ("us", 1000)):
        if ns % size == 0:
            return f"{ns // size} {unit}"
    return f"{text(Fraction(ns, MS))} ms"


class Limits:
    """What is allowed of a figure: from `low` to `high`, both included; None where there is no limit."""

    def __init__(self, low, high, style="range", at_most=False):
        self.low, self.high, self.style, self.at_most = low, high, style, at_most

    def allow(self, figure):
        return (self.low is None or figure >= self.low) and (self.high is None or figure <= self.high)

    def margin(self, figure):
        """How far it is from the nearest limit, below 0 beyond it; None without limits."""
        gaps = ([] if self.low is None else [figure - self.low]) + ([] if self.high is None else [self.high - figure])
        return min(gaps) if gaps else None

    def written(self, write, unit=""):
        """As a plan writes a range; `write` makes a text of a number."""
        unit = f" {unit}" if unit else ""
        if self.at_most:
            return f"{write(self.high)}{unit}"
        if self.low is None:
            return f".. {write(self.high)}{unit}"
        if self.high is None:
            return f"{write(self.low)}{unit} .."
        if self.style == "tolerance":
            middle = Fraction(self.low + self.high, 2)
            # Of what is in percent itself a tolerance without a unit beside the number is a part of a plain number.
            return f"{write(middle)}{unit if unit == ' %' else ''} ± {write(self.high - middle)}{unit}"
        return f"{write(self.low)} .. {write(self.high)}{unit}"


class Wanted:
    """Which values a claim wants: one of several, or within limits."""

    def __init__(self, values=None, limits=None):
        self.values, self.limits = values, limits

    def has(self, value):
        if self.values is not None:
            return value in self.values
        return self.limits.allow(value)
