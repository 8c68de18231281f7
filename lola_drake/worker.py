"""A process that does one thing after the other for a study; see `workers`.

It is told what by pickles on stdin and answers by pickles on stdout. When stdin ends, so does it:
whoever wanted the answers is gone. SIGTERM asks it to end what it does and give what is there.
Ctrl-C in a terminal reaches it, too, but that is for the study to pass on.
"""

import os
import pickle
import queue
import signal
import sys
import threading

from lola_drake.interruption import ASKED, HEARD


def main() -> None:
    """Serve until stdin ends."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # The next run, which may still be on its way, is to end at once; so are all after it.
    signal.signal(signal.SIGTERM, lambda *_: ASKED.set())
    orders: queue.SimpleQueue = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(orders,), daemon=True).start()
    while True:
        function, item = orders.get()
        try:
            answer = True, function(item)
        except Exception as error:
            answer = False, error
        pickle.dump((*answer, ASKED.is_set() or HEARD.is_set()), answers)
        answers.flush()


def _listen(orders: queue.SimpleQueue) -> None:
    """Take orders; end the whole process with their source, even in the middle of a run."""
    try:
        while True:
            orders.put(pickle.load(sys.stdin.buffer))
    finally:
        os._exit(0)


if __name__ == "__main__":
    main()
