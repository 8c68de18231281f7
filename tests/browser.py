"""A page in a headless browser: what a script in it answers, and what there is to complain of."""

import json
import os
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path
from urllib.parse import urlsplit

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")

OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--remote-debugging-pipe",
)

SETTLED = """
const settled = async (test, tries = 600) => {
  while (!test() && tries--) await new Promise(done => setTimeout(done, 100));
};
// What sticks out of the window, and what is too small for a finger.
const misfits = () => [
  ...[document.documentElement].filter(page => page.scrollWidth > innerWidth),
  ...document.querySelectorAll("button, select, summary, .arena .curves li"),
].filter(e => e.scrollWidth > innerWidth || e.offsetHeight && e.offsetHeight < 36)
  .map(e => `${e.tagName} ${e.textContent.slice(0, 20)} ${e.scrollWidth} ${e.offsetHeight}`);
// How light the sky over the robot is, from 0 to 255, in the window of a page of Meshcat's.
const skyIn = ({ viewer }) => viewer.scene_tree.find(["Background", "<object>"]).object.top_color.r;
"""

GIVE_UP = 120.0
"""After this (s) a browser that says nothing is ended, and the test fails."""


def ask(
    page: Path | str, question: str, *, width: int = 1400, dark: bool = False
) -> tuple[object, list[str]]:
    """Open a page, run a script in it, and return its answer and all complaints.

    Those are errors and warnings of the console, and whatever is asked of the net.

    Args:
        page: An HTML file, or the address of one that this machine serves.
        question: Statements that return the answer; `await settled(() => …)` waits.
        width: Of the window (pixels).
        dark: Whether the reader has chosen dark pages.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        url = page if isinstance(page, str) else page.resolve().as_uri()
        browser = _Browser(profile, urlsplit(url).hostname or "")
        try:
            browser.look(width, dark=dark)
            browser.open(url)
            answer = browser.evaluate(f"(async () => {{ {SETTLED} {question} }})()")
        finally:
            browser.close()
        return answer, browser.complaints


class _Browser:
    """One tab, steered by Chromium's own protocol through a pair of pipes."""

    def __init__(self, profile: str, host: str):
        self._host = host
        theirs_in, self._to = os.pipe()
        self._from, theirs_out = os.pipe()
        # Chromium reads from 3 and writes to 4, the first two of what it is given.
        command = f'exec 3<&{theirs_in} 4>&{theirs_out}; exec "$@"'
        self._process = subprocess.Popen(
            ["bash", "-c", command, "bash", CHROMIUM, *OPTIONS]
            + [f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(theirs_in, theirs_out),
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._reader = os.fdopen(self._from, "rb")
        self._alarm = threading.Timer(GIVE_UP, self._process.kill)
        self._alarm.start()
        self._count, self._session, self.complaints = 0, None, []
        pages = self._call("Target.getTargets")["targetInfos"]
        target = next(each["targetId"] for each in pages if each["type"] == "page")
        attached = self._call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._call(f"{domain}.enable")

    def look(self, width: int, *, dark: bool) -> None:
        """Have a window of this width, also of a phone's, and a choice of light or dark."""
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        self._call("Emulation.setDeviceMetricsOverride", **size)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._call("Emulation.setEmulatedMedia", features=[scheme])

    def open(self, url: str) -> None:
        self._call("Page.navigate", url=url)
        ready = "document.readyState === 'complete' && location.protocol !== 'about:'"
        while not self.evaluate(ready):
            pass

    def evaluate(self, script: str) -> object:
        done = self._call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in done, done
        return done["result"].get("value")

    def close(self) -> None:
        self._alarm.cancel()
        self._process.kill()
        self._process.wait()
        self._reader.close()
        os.close(self._to)

    def _call(self, method: str, **parameters) -> dict:
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = json.loads(self._message())
            if answer.get("id") == self._count:
                assert "error" not in answer, answer
                return answer["result"]
            self._notice(answer.get("method"), answer.get("params", {}))

    def _message(self) -> bytes:
        message = bytearray()
        while (byte := self._reader.read(1)) != b"\0":
            assert byte, "the browser has ended"
            message += byte
        return bytes(message)

    def _notice(self, method: str | None, told: dict) -> None:
        if method == "Runtime.exceptionThrown":
            self.complaints.append(json.dumps(told["exceptionDetails"])[:500])
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning"):
            self.complaints.append(json.dumps(told["args"])[:500])
        elif method == "Log.entryAdded" and told["entry"]["level"] == "error":
            self.complaints.append(told["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            url = told["request"]["url"]
            mine = urlsplit(url).hostname == self._host
            if not mine and not url.startswith(("file:", "data:", "blob:", "about:")):
                self.complaints.append(f"asks the net for {url}")
