"""What a worker of a cluster is sent: this package, and a function that calls one of it.

This module is sent by value and read where there is no lola_drake, so it must not need it.
"""

import io
import os
import pickle
import socket
import sys
import zipfile
from pathlib import Path

import cloudpickle
from distributed import Worker, WorkerPlugin

cloudpickle.register_pickle_by_value(sys.modules[__name__])

PACKAGE = "lola_drake"


class SentPackage(WorkerPlugin):
    """Lets a worker find this package, and not the one that it has."""

    name = PACKAGE
    idempotent = False

    def __init__(self, content: bytes):
        """Keep the content of the package, zipped."""
        self.content = content

    @classmethod
    def of_this_one(cls) -> "SentPackage":
        """Return the package as it is here."""
        from lola_drake.paths import models_dir

        package, content = Path(__file__).resolve().parents[1], io.BytesIO()
        with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as file:
            for folder, name in ((package, PACKAGE), (models_dir(), f"{PACKAGE}/models")):
                for path in sorted(folder.rglob("*")):
                    inside = path.relative_to(folder)
                    if path.is_file() and not {"__pycache__", "models"} & set(inside.parts):
                        file.write(path, f"{name}/{inside}")
        return cls(content.getvalue())

    def setup(self, worker: Worker) -> None:
        """Unpack the package where the worker looks first."""
        folder = Path(worker.local_directory) / "sent"
        with zipfile.ZipFile(io.BytesIO(self.content)) as file:
            file.extractall(folder)
        sys.path.insert(0, str(folder))
        for name in list(sys.modules):
            if name.partition(".")[0] == PACKAGE:
                del sys.modules[name]


def call(order: bytes) -> bytes:
    """Return a function's answer, or its error, and who has made it; all pickled."""
    function, item = pickle.loads(order)
    worker = f"{os.getpid()}@{socket.gethostname()}"
    try:
        return pickle.dumps((True, function(item), worker))
    except Exception as error:
        return pickle.dumps((False, error, worker))


# Functions of __main__ are sent by value, also to the scheduler, which never gets the package.
call.__module__ = "__main__"
