"""What the tests of build, refine and explain share: the commands, and how their results are compared with the module's."""

import html.parser
import json
import os
import subprocess
from types import SimpleNamespace

TOOLS = {name: os.environ[name.upper()] for name in ("crgbuild", "lidar2mesh", "crgexplain")}


def command(tool, *words, code=0):
    ran = subprocess.run([TOOLS[tool], *map(str, words)], capture_output=True, text=True, check=False)
    assert ran.returncode == code, ran.stderr
    return ran


def same_folders(by_command, by_python):
    """Every file of one is in the other with the same bytes; but what differs from run to run, and which program it was."""
    names = sorted(path.name for path in by_command.iterdir())
    assert names == sorted(path.name for path in by_python.iterdir())
    for name in names:
        a, b = (by_command / name).read_bytes(), (by_python / name).read_bytes()
        if name == "timing.json":
            assert json.loads(a).keys() == json.loads(b).keys()
        elif name == "manifest.json":
            of_command, of_python = json.loads(a), json.loads(b)
            assert of_command.pop("program_sha256") != of_python.pop("program_sha256")
            assert of_command == of_python
        elif not name.endswith(".clean.cache"):
            assert a == b, name
    return names


def same_values(values, data):
    """Attributes of `values` are the keys of JSON, all the way down."""
    if isinstance(data, dict):
        assert isinstance(values, SimpleNamespace)
        assert list(vars(values)) == list(data)
        for key, below in data.items():
            same_values(getattr(values, key), below)
    elif isinstance(data, list):
        assert len(values) == len(data)
        for one, other in zip(values, data):
            same_values(one, other)
    else:
        assert values == data and type(values) is type(data)


def framed_page(shown):
    """The page in what a notebook is given, as a browser reads it."""
    found = []

    class Reader(html.parser.HTMLParser):
        def handle_starttag(self, tag, attrs):
            found.append((tag, dict(attrs)))

    Reader().feed(shown)
    ((tag, attributes),) = found
    assert tag == "iframe" and attributes["sandbox"] == "allow-scripts"
    return attributes["srcdoc"].encode()
