"""Nobody but the page gets anything from the server, and nothing that is sent to it does any harm."""

import http.client
import json
import random
import socket
import time

import pytest
import trimesh
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from tests.experiments.design.served import heard, is_known, served


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("guard")
    trimesh.creation.box((20, 20, 2)).export(folder / "plate.stl")
    with served(folder, folder / "plate.stl", "--cameras", 3) as running:
        with running.socket() as live:
            heard(live, "state", is_known)
        time.sleep(0.5)  # what is known of the first layout is kept, too
        yield running


@pytest.fixture(autouse=True)
def nothing_has_happened(server):
    """Whatever a test sends, nothing is written, and the session goes on."""
    before = server.kept()
    yield
    with server.socket() as live:
        state = heard(live, "state", is_known)
    assert state["angles"] == before[0]["tried"][-1]["layout"]["angles_rad"]
    assert server.kept() == before
    assert server.process.poll() is None


def asked(server, path, method="GET", headers=(), body=None):
    """Status, headers and content of the answer to a request."""
    connection = http.client.HTTPConnection("127.0.0.1", server.parts.port, timeout=60)
    connection.putrequest(method, path, skip_host=True)
    for name, value in {"Host": server.parts.netloc, **dict(headers)}.items():
        if value is not None:
            connection.putheader(name, value)
    connection.endheaders(body)
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer.status, dict(answer.getheaders()), content


def test_the_page_is_served_with_a_strict_policy(server):
    status, headers, content = asked(server, server.parts.path)
    assert status == 200 and b"camring design" in content
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy and "unsafe" not in policy and "*" not in policy
    assert headers["x-content-type-options"] == "nosniff" and headers["referrer-policy"] == "no-referrer"
    assert headers["cache-control"] == "no-store"


@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/static/page.js",
        "/live",
        "//",
        "/wrong/",
        "/wrong/static/page.js",
        "/save/layout.json",
        "/%00/",
        "/%C3%A4/",
    ],
)
def test_nothing_without_the_secret(server, path):
    status, headers, content = asked(server, path)
    assert (status, content) == (403, b"not for you\n")
    assert "default-src 'none'" in headers["content-security-policy"]


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"}, {"Host": "localhost"}, {"Host": None}, {"Host": "127.0.0.1"},
        {"Origin": "https://evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "same-site"},
    ],
)  # fmt: skip
def test_nothing_for_others(server, headers):
    status, _, content = asked(server, server.parts.path, headers=headers)
    assert status in (400, 403) and b"camring design" not in content
    more = {name: value for name, value in headers.items() if name not in ("Host", "Origin")}
    live = f"ws://{server.parts.netloc}{server.parts.path}live"
    if "Host" not in headers:
        with (
            pytest.raises(InvalidStatus, match="403"),
            connect(live, origin=headers.get("Origin", server.origin), additional_headers=more),
        ):
            pass


def test_a_socket_must_say_where_it_is_from(server):
    live = f"ws://{server.parts.netloc}{server.parts.path}live"
    elsewhere = live.replace("/live", "x/live")
    for address, origin in ((live, None), (live, "http://evil.example"), (elsewhere, server.origin)):
        with pytest.raises(InvalidStatus, match="403"), connect(address, origin=origin):
            pass


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "HEAD", "TRACE"])
def test_it_only_gives(server, method):
    assert asked(server, server.parts.path, method)[0] == 403


@pytest.mark.parametrize(
    "path",
    ["static/../../../../etc/passwd", "static/%2e%2e%2fpage.js", "static/..", "static//etc/passwd", "static/page.py",
     "save/session.json", "save/..%2flayout.json", "save/", "nothing", "static/page.js/.."],
)  # fmt: skip
def test_no_path_is_opened(server, path):
    status, _, content = asked(server, server.parts.path + path)
    assert status == 404 and len(content) < 100 and b"root:" not in content


def test_a_hundred_megabytes_are_not_read(server):
    for path in (server.parts.path, "/"):
        with socket.create_connection(("127.0.0.1", server.parts.port), timeout=60) as raw:
            head = f"POST {path} HTTP/1.1\r\nHost: {server.parts.netloc}\r\nContent-Length: {10**8}\r\n\r\n"
            raw.sendall(head.encode())
            sent = 0
            try:
                while sent < 10**8:
                    sent += raw.send(b"x" * 65536)
            except OSError:
                pass
            assert sent < 10**8
    with server.socket() as live:
        with pytest.raises(ConnectionClosed):
            live.send("x" * 10**8)
            heard(live, "no such kind")


def nonsense(rng):
    """A message as no page sends it."""
    values = [None, True, -1, 0, 1, 10**30, 1.5, float("nan"), float("inf"), "", "<b>", "x" * 3000, [[]], {"do": 1}]
    known = [
        "drag",
        "nudge",
        "turn",
        "add",
        "remove",
        "fix",
        "forbid",
        "go",
        "place",
        "improve",
        "optimise",
        "one more",
    ]
    kinds = [*known, "allow", "open", "save", "__class__", ""]
    names = [
        "camera",
        "angle",
        "angles",
        "by",
        "name",
        "value",
        "place",
        "fixed",
        "start",
        "end",
        "arc",
        "number",
        "text",
        "x",
    ]
    message = {"do": rng.choice([*kinds, *values])}
    for name in rng.sample(names, rng.randint(0, 4)):
        message[name] = rng.choice(values)
    # What would be understood is no nonsense.
    if message["do"] in known:
        message["x"] = 1
    return message


def test_a_thousand_random_messages_change_nothing(server):
    rng = random.Random(0)
    with server.socket() as live:
        for number in range(1000):
            text = json.dumps(nonsense(rng))
            if number % 7 == 0:
                text = text[: rng.randint(0, len(text))]
            live.send(rng.randbytes(40) if number % 11 == 0 else text)
        live.send("[" * 100_000)
        said = heard(live, "said")["words"]
        assert "message" in said and "fault" not in said
        state = heard(live, "state", is_known)
        assert len(state["angles"]) == 3 and not state["held"]


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ("{", "no JSON"),
        ({"do": "fly"}, "not understood"),
        ({"do": "drag", "camera": 3, "angle": 0}, "camera is 3"),
        ({"do": "drag", "camera": 0, "angle": "1"}, "angle is '1'"),
        ({"do": "drag", "camera": True, "angle": 1}, "camera is True"),
        ({"do": "drag", "camera": 0}, "has camera, angle beside"),
        ({"do": "turn", "name": "__init__", "value": 1}, "name is '__init__'"),
        ({"do": "turn", "name": "diameter", "value": 1e300}, "ring diameter is 1e+300"),
        ({"do": "turn", "name": "diameter", "value": None}, "ring diameter needs a number"),
        ({"do": "turn", "name": "diameter", "value": 2.0}, "do not meet the constraints"),
        ({"do": "turn", "name": "threshold", "value": 1.5}, "threshold is 1.5"),
        ({"do": "turn", "name": "threshold", "value": 9}, "threshold is 9 with 3 cameras"),
        ({"do": "forbid", "start": 0.0, "end": 6.0}, "do not meet the constraints"),
        ({"do": "allow", "arc": 0}, "there is no forbidden arc 1"),
        ({"do": "go", "number": 99}, "no layout 99"),
        ({"do": "open", "text": "{}"}, "the file is not a layout file"),
        ({"do": "place", "angles": []}, "angles is []"),
        ({"do": "place", "angles": [0.0, "1"]}, "angles is [0.0, '1']"),
        ({"do": "place", "angles": [0.1 * i for i in range(99)]}, "angles is [0.0, 0.1"),
        ({"do": "place", "angles": [0.0, 0.001]}, "do not meet the constraints"),
        ({"do": "open", "text": "x" * 600_000}, "text is 'xxx"),
    ],
)
def test_what_cannot_be_is_refused_in_words(server, message, words):
    with server.socket() as live:
        heard(live, "state", is_known)
        live.send(message if isinstance(message, str) else json.dumps(message))
        assert words in heard(live, "said")["words"]
