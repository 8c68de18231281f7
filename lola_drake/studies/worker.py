"""A process that does one thing after the other for a study; see `workers`.

It is told what by pickles on stdin and answers by pickles on stdout. When stdin ends, so does it:
whoever wanted the answers is gone.
"""

import os
import pickle
import queue
import signal
import sys
import threading


def main() -> None:
    """Serve until stdin ends."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    working = False

    def stop(*_) -> None:
        # Once it is on its way a run attends to this by itself; between two there is none.
        if working:
            raise KeyboardInterrupt

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    orders: queue.SimpleQueue = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(orders,), daemon=True).start()
    while True:
        function, item = orders.get()
        try:
            working = True
            answer = True, function(item)
            working = False
        except (Exception, KeyboardInterrupt) as error:
            working = False
            answer = False, error
        pickle.dump(answer, answers)
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
