"""The one error of the analyses, and the net under Drake's assertions."""

from collections.abc import Iterator
from contextlib import contextmanager

from lola_drake.errors import LolaError


class AnalysisError(LolaError):
    """An analysis that is not possible as asked; the message is one line that says why."""


@contextmanager
def drake_errors(doing: str) -> Iterator[None]:
    """Turn what Drake raises into one AnalysisError; a failed assertion there is a SystemExit.

    Args:
        doing: what is tried, as the beginning of the message.
    """
    try:
        yield
    except AnalysisError:
        raise
    except (Exception, SystemExit) as error:
        lines = str(error).strip().splitlines() or [type(error).__name__]
        raise AnalysisError(f"{doing}: {lines[0]}") from error
