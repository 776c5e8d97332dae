"""Runs the Python of a page of the docs in an empty folder: run_example.py PAGE."""

import os
import re
import sys
import tempfile

with open(sys.argv[1], encoding="utf-8") as page:
    blocks = re.findall(r"^```python\n(.*?)^```", page.read(), re.DOTALL | re.MULTILINE)
if not blocks:
    sys.exit(f"{sys.argv[1]}: no Python in it")
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    for block in blocks:
        exec(compile(block, sys.argv[1], "exec"), {})
    os.chdir("/")
