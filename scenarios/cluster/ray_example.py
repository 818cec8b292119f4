"""A campaign in shards on a Ray cluster whose nodes share a folder: python ray_example.py 16 OUT FILE.scn …

Ray only finds free processors here. A shard is a process of its own, and needs nothing of Ray's.
"""

import subprocess
import sys

import ray

THREADS = 4


@ray.remote(num_cpus=THREADS, max_retries=3, retry_exceptions=[subprocess.CalledProcessError])
def shard(index: int, count: int, out: str, files: list[str]) -> int:
    options = ["--shard", f"{index}/{count}", "--threads", str(THREADS), "--out", out]
    subprocess.run(["falsify", "run", *options, *files], check=True)
    return index


if __name__ == "__main__":
    count, out, files = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
    ray.init()
    ray.get([shard.remote(index, count, out, files) for index in range(count)])
    merge = ["falsify", "merge", "--shards", str(count), "--out", out, *files]
    sys.exit(subprocess.run(merge).returncode)
