"""Parses tables of decimal numbers into arrays, about ten times as fast as `float` word by word."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats

MOST_DIGITS = 18  # that an int64 holds; further digits are below a float's precision
EXACT_POWER = 22  # the largest power of ten that a float holds exactly
LARGEST_POWER = 308  # the largest power of ten that a float holds at all
POWERS = np.array([float(10**power) for power in range(MOST_DIGITS + 1)])


def read_table(text: NDArray[np.uint8], rows: int, width: int) -> Floats | None:
    """Returns the numbers [rows, width] of a text, as bytes, with one row per line; blank lines are skipped.

    None if the text has other rows, other words or numbers that are not finite. Numbers of up to 15 digits and 22
    decimal places equal what `float` returns; others agree to 14 digits.
    """
    if rows < 0 or rows * width > len(text):  # each number needs a byte: no allocation for data that cannot be there
        return None
    values = np.empty((rows, width))
    return values if fill_table(text, values) and np.isfinite(values).all() else None


def as_bytes(text: str) -> NDArray[np.uint8]:
    """Returns a text as `read_table` needs it."""
    return np.frombuffer(text.encode(), np.uint8)


def is_finite(word: str) -> bool:
    """Returns whether a word is a finite number."""
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


@compiled(nogil=True, error_model="numpy")
def fill_table(text: NDArray[np.uint8], values: Floats) -> bool:
    """Parses `text` into `values` [rows, width]. Returns whether it has exactly these rows of numbers."""
    rows, width = values.shape
    row = column = i = 0
    while i < len(text):
        mark = text[i]
        if mark == 10:  # the line ends
            if column == width:
                row, column = row + 1, 0
            elif column > 0:
                return False
            i += 1
            continue
        if mark == 32 or mark == 9 or mark == 13:
            i += 1
            continue
        if row == rows or column == width:
            return False
        negative = mark == 45
        if negative or mark == 43:
            i += 1
        begin, point, mantissa = i, -1, np.int64(0)  # first a number as nearly all are, of few digits and no exponent
        while i < len(text):
            digit = np.int64(text[i]) - 48
            if 0 <= digit <= 9:
                mantissa = mantissa * 10 + digit
            elif digit == -2 and point < 0:
                point = i
            else:
                break
            i += 1
        after = i - point - 1 if point >= 0 else 0
        read = i - begin - (1 if point >= 0 else 0)
        if 0 < read <= MOST_DIGITS and (i == len(text) or text[i] <= 32):
            number = float(mantissa) if after == 0 else float(mantissa) / POWERS[after]
            values[row, column] = -number if negative else number
            column += 1
            continue
        i = begin
        mantissa, digits, power, read = np.int64(0), 0, 0, 0
        after_point = False
        while i < len(text):
            mark = text[i]
            if 48 <= mark <= 57:
                read += 1
                if digits < MOST_DIGITS:
                    mantissa = mantissa * 10 + int(mark - 48)
                    digits += 1 if mantissa > 0 else 0
                    power -= 1 if after_point else 0
                else:
                    power += 0 if after_point else 1
            elif mark == 46 and not after_point:
                after_point = True
            else:
                break
            i += 1
        if read == 0:
            return False
        if i < len(text) and (text[i] == 101 or text[i] == 69):
            i += 1
            down = i < len(text) and text[i] == 45
            if down or (i < len(text) and text[i] == 43):
                i += 1
            exponent, read = 0, 0
            while i < len(text) and 48 <= text[i] <= 57:
                if exponent <= LARGEST_POWER:
                    exponent = exponent * 10 + int(text[i] - 48)
                read += 1
                i += 1
            if read == 0:
                return False
            power += -exponent if down else exponent
        if i < len(text) and text[i] > 32:
            return False
        if power > LARGEST_POWER:
            return False
        number = float(mantissa)
        if power < -EXACT_POWER:
            number = number / 10.0**EXACT_POWER / 10.0 ** min(-power - EXACT_POWER, LARGEST_POWER)
        elif power < 0:
            number = number / 10.0**-power
        elif power > 0:
            number = number * 10.0**power
        values[row, column] = -number if negative else number
        column += 1
    if column == width:
        row, column = row + 1, 0
    return row == rows and column == 0
