"""Only a page that has the token may steer a running simulation, in a browser or without one."""

import base64
import os
import socket
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import urlsplit

import pytest
from browser import ask, needs_browser

from lola_drake.errors import OutputError
from lola_drake.scenario import load_scenario
from lola_drake.simulation import simulate
from lola_drake.view3d.door import EVERYWHERE, Door, knows, named
from lola_drake.view3d.live import LiveView
from lola_drake.view3d.scene import open_meshcat


@pytest.fixture(scope="module")
def meshcat():
    return open_meshcat(hidden=True)


@pytest.fixture
def door(meshcat):
    door = Door("localhost", meshcat.web_url())
    yield door
    door.close()


def answer(url):
    """Return status and content of what there is at an address."""
    try:
        with urllib.request.urlopen(url) as given:
            return given.status, given.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


def handshake(door, path):
    """Ask for a WebSocket; return the first line of the answer, and the socket."""
    client = socket.create_connection(("localhost", door.port), timeout=10)
    key = base64.b64encode(os.urandom(16)).decode()
    lines = (
        f"GET {path} HTTP/1.1",
        f"Host: localhost:{door.port}",
        "Upgrade: websocket",
        "Connection: keep-alive, Upgrade",
        f"Sec-WebSocket-Key: {key}",
        "Sec-WebSocket-Version: 13",
        "Origin: https://evil.example",
    )
    client.sendall("\r\n".join([*lines, "", ""]).encode())
    return client.recv(65536).split(b"\r\n")[0].decode(), client


def test_a_page_needs_the_token_and_its_files_do_not(door, meshcat):
    status, page = answer(door.url)
    start, end = answer(meshcat.web_url())[1].split(b"</body>")
    assert status == 200 and page.startswith(start) and page.endswith(end) and b"sky(" in page
    base = f"http://localhost:{door.port}"
    for path in ("/", "/index.html", "/?token=", "/?token=x", f"/{door.token}", "/meshcat.html"):
        assert answer(base + path)[0] in (403, 404), path
    script = page.split(b'src="')[1].split(b'"')[0].decode()
    assert answer(f"{base}/{script}") == answer(f"{meshcat.web_url()}/{script}")


@pytest.mark.parametrize("path", ["/", "/?token=x", "/?token=\xfc", "/?token", "/stats"])
def test_a_socket_needs_the_token(door, meshcat, path):
    line, client = handshake(door, path)
    assert " 403 " in line
    # What comes behind it reaches nobody: these frames would end Meshcat.
    with client:
        client.sendall(bytes([0x82, 0x80, 0, 0, 0, 0]) * 3 + os.urandom(64))
    assert answer(door.url)[0] == 200


def test_with_the_token_a_socket_is_meshcats(door, meshcat):
    line, client = handshake(door, f"/?token={door.token}")
    with client:
        assert " 101 " in line


def test_the_hidden_server_is_at_no_address_that_one_guesses(door, meshcat):
    inside = urlsplit(meshcat.web_url())
    assert inside.hostname.startswith("127.") and inside.hostname != "127.0.0.1"
    assert door.token not in meshcat.web_url()


def test_a_port_in_use_gives_the_next_one(door, meshcat):
    another = Door("localhost", meshcat.web_url())
    assert another.port > door.port and another.token != door.token
    assert answer(another.url)[0] == 200
    assert answer(f"http://localhost:{another.port}/?token={door.token}")[0] == 403
    another.close()


@pytest.mark.parametrize("host", ["8.8.8.8", "no such host", "x" * 300])
def test_a_host_that_is_not_here_is_one_line(host):
    with pytest.raises(OutputError, match="no page can be shown at"):
        Door(host, "http://localhost:1")


def test_everywhere_is_here_too(meshcat):
    door = Door(EVERYWHERE, meshcat.web_url())
    assert named(EVERYWHERE) in door.url and answer(door.url)[0] == 200
    door.close()


def test_tokens_are_compared_whole():
    assert knows("ab", "/?token=ab") and knows("ab", "/x?y=1&token=ab")
    for path in ("/", "/?token=a", "/?token=abc", "/?Token=ab", "/ab", "/?token=%00"):
        assert not knows("ab", path)


EVIL = """
<!doctype html><title>another origin</title><script>
const tried = async url => new Promise(done => {
  const socket = new WebSocket(url);
  socket.onopen = () => { socket.send(new Uint8Array(0)); done("open"); };
  socket.onerror = () => done("refused");
});
</script>
"""


@needs_browser
def test_a_page_of_another_origin_moves_nothing(door, meshcat, tmp_path):
    """It knows the machine and the port, and is open in the same browser."""
    (tmp_path / "evil.html").write_text(EVIL)
    view = LiveView(load_scenario("stand"), meshcat)
    question = f"""
        const base = "localhost:{door.port}/";
        const found = [];
        for (const path of ["", "?token=", "?token=x", "index.html?token=0"])
          found.push(await tried(`ws://${{base}}${{path}}`));
        try {{ found.push((await fetch(`http://${{base}}`)).status); }}
        catch (error) {{ found.push("unread"); }}
        return found;
    """
    with ThreadPoolExecutor() as pool:
        asked = pool.submit(ask, tmp_path / "evil.html", question)

        def attend(run):
            step = view(run)
            return None if asked.done() else step

        result = simulate(load_scenario("stand", {"duration": 3600.0}), attend=attend)
    assert asked.result()[0] == ["refused"] * 4 + ["unread"]
    # Nobody has looked: the simulation has waited all the time.
    assert result.error is None and result.duration == 0.0 and not view.interfered
