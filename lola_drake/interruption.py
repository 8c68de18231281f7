"""Ctrl-C and SIGTERM while something must come to its end first."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM)

ASKED = threading.Event()
"""Set where the end was asked for before there was anything to end."""

HEARD = threading.Event()
"""Set by every request to end something; cleared by who wants to know of the next one."""


@contextmanager
def interruption() -> Iterator[threading.Event]:
    """Turn Ctrl-C and SIGTERM into an event for a while; only the main thread can be asked."""
    event = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield event
        return
    if ASKED.is_set():
        event.set()

    def ask(*_) -> None:
        event.set()
        HEARD.set()

    before = {
        number: signal.signal(number, ask)
        for number in SIGNALS
        if signal.getsignal(number) != signal.SIG_IGN
    }
    try:
        yield event
    finally:
        for number, handler in before.items():
            # None: it was not Python that had set it.
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)
