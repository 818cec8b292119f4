"""A campaign in shards on a Ray cluster whose nodes share a folder: python ray_example.py 16 OUT FILE.scn …

Ray only finds free processors here. A shard is a process of its own, and needs nothing of Ray's.
"""

import subprocess
import sys

import ray

THREADS = 4  # at most, for a shard
AGAIN = {1, 130}  # killed or a bug, stopped; another exit code comes again with every attempt


class Stopped(Exception):
    """The shard may succeed at another attempt."""


def threads():
    """Ray waits for ever for a node that has more processors than all have, so a shard takes no more than the smallest node has."""
    processors = [int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"]]
    return min([THREADS, *filter(None, processors)])


@ray.remote(max_retries=3, retry_exceptions=[Stopped])
def shard(index: int, count: int, cores: int, out: str, files: list[str]) -> int:
    options = ["--shard", f"{index}/{count}", "--threads", str(cores), "--out", out]
    code = subprocess.run(["falsify", "run", *options, *files]).returncode
    if code in AGAIN or code < 0:
        raise Stopped(f"shard {index} ended with {code}")
    return code


if __name__ == "__main__":
    count, out, files = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
    ray.init()
    cores = threads()
    shards = [shard.options(num_cpus=cores).remote(index, count, cores, out, files) for index in range(count)]
    for index, each in enumerate(shards):
        try:
            if code := ray.get(each):
                print(f"shard {index} failed with exit code {code}", file=sys.stderr)
        except ray.exceptions.RayError as error:
            print(f"shard {index} failed: {error}", file=sys.stderr)
    # It names the shards that are missing.
    merge = ["falsify", "merge", "--shards", str(count), "--out", out, *files]
    sys.exit(subprocess.run(merge).returncode)
