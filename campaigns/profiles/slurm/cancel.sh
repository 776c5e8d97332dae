#!/bin/sh
# Cancels jobs by the names that submit.py gave them.
for name in "$@"; do scancel --name="$name"; done
