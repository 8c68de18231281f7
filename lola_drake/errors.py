"""The family of all errors that a user of this package may meet."""

import reprlib


class LolaError(ValueError):
    """Something that cannot be used or done; the message is one line that says what and why."""


class ResultError(LolaError):
    """A run that cannot be saved or loaded."""


class OutputError(LolaError):
    """A picture, page or export that cannot be made."""


_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 26
_REPR.maxlevel = 2
_LONGEST = 30


def shown(value: object) -> str:
    """Return a value as it stands in a message: recognisable, printable, and never long."""
    return short(_REPR.repr(value), _LONGEST)


def short(text: str, longest: int) -> str:
    """Return a text without anything that a terminal could obey, its middle cut if it is long."""
    text = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
    half = longest // 2 - 2
    return text if len(text) <= longest else f"{text[:half]}...{text[-half:]}"
