"""Measures sizes and times of exports, as a table in Markdown:

    python tests/exports/measure.py PROGRAM <names.txt

Each format exports the whole list once into an empty folder. The time is that of the process, with the repetition of each episode and the
writing of the files, divided by the number of episodes.
"""

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FORMATS = ["xosc-1.3", "xosc-1.0", "xodr", "osi", "foxglove", "commonroad", "carla", "gif"]


def kilobytes(files):
    return f"{statistics.median(file.stat().st_size for file in files) / 1000:.0f} kB" if files else "-"


def main(program, names):
    count = len(names.split())
    print(f"{count} episodes; median of the sizes\n\n| format | size | its map | time of an episode |\n|---|---|---|---|")
    for name in FORMATS:
        with tempfile.TemporaryDirectory() as folder:
            start = time.perf_counter()
            command = [program, "export", "-", "--as", name, "--out", folder]
            done = subprocess.run(command, input=names, text=True, capture_output=True)
            seconds = time.perf_counter() - start
            maps = sorted(Path(folder).glob("*.xodr"))
            files = sorted(set(Path(folder).iterdir()) - set(maps)) or maps
            failed = "" if done.returncode == 0 else f" (exit code {done.returncode}: {done.stderr.splitlines()[0]})"
            print(f"| `{name}` | {kilobytes(files)} | {kilobytes(maps)} | {1000 * seconds / count:.0f} ms{failed} |")


if __name__ == "__main__":
    main(sys.argv[1], sys.stdin.read())
