"""Text in any encoding and with any line ends, as bytes of which all that matters is ASCII."""

import codecs
import re

# How a file in UTF-16 begins.
UTF_16 = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
# So many bytes tell a text in UTF-16 that does not say so: every other one is 0.
ENOUGH = 8


def plain(data: bytes) -> bytes:
    r"""The text of a file without byte-order mark, in an encoding that has ASCII in it, and with \n at the line ends.

    Letters outside of ASCII, such as in comments and names, stay as they are, in whatever encoding.

    Examples
    --------
    >>> plain(b"\xef\xbb\xbfsolid\r\nfacet\rx"), plain("v 1\n".encode("utf-16"))
    (b'solid\nfacet\nx', b'v 1\n')
    """
    if data.startswith(codecs.BOM_UTF8):
        data = data[len(codecs.BOM_UTF8) :]
    elif encoding := next((UTF_16[mark] for mark in UTF_16 if data.startswith(mark)), _unmarked(data)):
        data = data.decode(encoding, errors="replace").lstrip("\ufeff").encode()
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _unmarked(data: bytes) -> str | None:
    head = data[:ENOUGH]
    if len(head) < ENOUGH:
        return None
    even, odd = head[::2], head[1::2]
    if not any(odd) and all(even):
        return "utf-16-le"
    return "utf-16-be" if not any(even) and all(odd) else None


def shown(line: bytes) -> str:
    """A line for a message: in quotes, not too long, nothing that a terminal would not print."""
    words = line.strip()[:60].decode("utf-8", errors="replace")
    return '"' + "".join(one if one.isprintable() else " " for one in words) + '"'


def numbers(words: list[bytes]) -> list[float]:
    """Numbers as programs write them, with the exponents of Fortran too.

    Raises
    ------
    ValueError
        If a word is no number.

    Examples
    --------
    >>> numbers([b"1.5", b"-2e3", b"1.D+02"])
    [1.5, -2000.0, 100.0]
    """
    try:
        return list(map(float, words))
    except ValueError:
        return [float(re.sub(rb"^([+-]?[\d.]+)[dD]([+-]?\d+)$", rb"\1e\2", word)) for word in words]
