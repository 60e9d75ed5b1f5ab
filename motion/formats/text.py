"""Text files of motion: their encoding, padding and decimal commas."""

from __future__ import annotations

import codecs

from motionsplice.motion.errors import FormatError

PADDING = "\0\x1a"  # the second is Ctrl-Z, the end of a text file in DOS
COMMAS = "its decimal commas were read as decimal points"
OLDER = ("cp932", "gb18030", "big5")  # Japanese and Chinese, in which joints have left and right in their names
PROBED = 64  # bytes that show UTF-16 without a byte order mark
FIRST_LETTER = 9  # a tab; lower codes do not occur in text


def text_of(data: bytes, mend: str) -> str:
    """Returns the text of a file, without byte order mark, and without the padding at its end.

    The encoding is UTF-8 or UTF-16, else the first of OLDER in which a name has left or right, else Windows-1252.
    Raises FormatError, with `mend`, if the file is not text or has nothing but padding.
    """
    text = _decoded(data)
    if "\0" in text or "\x1a" in text:
        end = len(text.rstrip(PADDING + " \t\r\n"))
        if end == 0:
            raise FormatError("the file is empty but for padding", mend=mend)
        text = text[:end] + text[end:].translate(dict.fromkeys(map(ord, PADDING)))
    if "\0" in text:
        raise FormatError("this is a binary file, not text", mend=mend)
    return text


def _decoded(data: bytes) -> str:
    encoding = _encoding(data)
    for candidate in (encoding, *OLDER):
        try:
            text = data.decode(candidate)
        except UnicodeDecodeError:
            continue
        if candidate == encoding or any(side in text for side in "左右"):
            return text
    return data.decode("cp1252" if encoding == "utf-8-sig" else encoding, errors="replace")


def _encoding(data: bytes) -> str:
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    even, odd = data[:PROBED:2], data[1:PROBED:2]
    for zeros, letters, encoding in ((odd, even, "utf-16-le"), (even, odd, "utf-16-be")):
        if zeros and letters and not any(zeros) and min(letters) >= FIRST_LETTER:
            return encoding
    return "utf-8-sig"


def with_points(text: str) -> str:
    """Returns numbers with decimal points in place of commas, if commas can be nothing else: no number has a point."""
    return text.replace(",", ".") if "," in text and "." not in text else text
