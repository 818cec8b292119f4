"""A driver for the tests, which fails in the way that its first argument names, in about every third episode or at once.

Further arguments: `binary` for the binary encoding, `second` for revision 2, a file's name to leave a mark in.
"""
import json, os, random, signal, struct, sys

mode, binary = sys.argv[1], "binary" in sys.argv[2:]
for name in sys.argv[2:]:
    if name not in ("binary", "second"):
        open(name, "a").write("started\n")

out = sys.stdout.buffer
marked = {}
count = 0

def say(data):
    if mode == "bytewise":
        for byte in data:
            out.write(bytes([byte]))
            out.flush()
    else:
        out.write(data)
        out.flush()

def hang():
    while True:
        signal.pause()

def fail(world, tick):
    """Goes wrong where the mode says so, in the marked episodes."""
    if not marked.get(world) or tick != 30:
        return
    if mode == "crash":
        os._exit(3)
    if mode == "killed":
        os.kill(os.getpid(), signal.SIGSEGV)
    if mode == "null":
        say(json.dumps({"actions": [{"id": world, "brake": None}]}).encode() + b"\n")
        hang()
    if mode == "huge":
        say(b'{"actions":[{"id":%d,"brake":1e999}]}\n' % world)
        hang()
    if mode == "text":
        say(json.dumps({"actions": [{"id": world, "throttle": "0.3"}]}).encode() + b"\n")
        hang()
    if mode == "late" and len(open(sys.argv[2]).readlines()) == 2:
        hang()
    if mode == "garbage":
        say(b"now I turn left\n")
        hang()
    if mode == "hang":
        hang()
    if mode == "endless":
        while True:
            say(b"x" * 65536)
    if mode == "half":
        say(b'{"actions":[')
        os._exit(0)

def control(world, tick, seed, x, speed, limit):
    global count
    count += 1
    if seed is not None:
        marked[world] = seed % 3 == 0
    fail(world, tick)
    extra = {"counting": count % 7, "random": random.random()}.get(mode, 0)
    return (0.6 if speed < 0.8 * limit else 0.0, 0.1 * extra + (0.2 if x % 40 < 4 else 0.0), 0.01 * (x % 3 - 1))

hello = json.loads(sys.stdin.buffer.readline())
assert hello["type"] == "hello" and hello["protocol"] == "falsify-av/1", hello
if mode == "silent":
    hang()
if mode == "gone":
    sys.exit()
answer = {"protocol": "falsify-av/9" if mode == "version" else "falsify-av/1", "name": "test"}
if mode == "misspelt":
    answer["revison"] = 2
if binary:
    answer["encoding"] = "binary"
if "second" in sys.argv[2:]:
    answer["revision"] = 2
if mode == "marked":
    say(b"\xef\xbb\xbf")
if mode == "loud":
    sys.stderr.write("title \x1b]0;mine\x07\n" + ("x" * 99 + "\n") * 30_000)
say(json.dumps(answer).encode() + b"\n")

if binary:
    lanes = hello["actors"] + 5 * hello["route_points"] if "revision" in answer else 0
    size = 14 + 8 * hello["actors"] + 3 * hello["route_points"] + lanes
    while head := sys.stdin.buffer.read(4):
        numbers = sys.stdin.buffer.read(struct.unpack("<I", head)[0])
        answer = b""
        for world in struct.iter_unpack(f"<{size}d", numbers):
            seed = None if world[2] < 0 else int(world[2])
            if lanes:
                assert world[13] > 0 and world[size - 5 * hello["route_points"] + 4] == world[7], "the limit here, again"
            answer += struct.pack("<4d", world[0], *control(int(world[0]), int(world[1]), seed, world[3], world[6], world[7]))
        say(struct.pack("<I", len(answer)) + answer)
else:
    for line in sys.stdin.buffer:
        actions = []
        if mode == "crowded" and len(json.loads(line)["worlds"]) > 1:
            os._exit(3)
        for world in json.loads(line)["worlds"]:
            throttle, brake, steer = control(
                world["id"], world["tick"], world.get("seed"), world["ego"]["x"], world["ego"]["speed"], world["speed_limit"]
            )
            actions.append({"id": world["id"], "throttle": throttle, "brake": brake, "steer": steer, "mode": "cruise"})
        if mode == "reversed":
            actions.reverse()
        if mode == "lazy":
            actions.pop()
        if mode == "nan":
            actions[0]["steer"] = float("nan")
        answer = json.dumps({"actions": actions}).encode() + b"\n"
        # Two answers in one write: the second is for a question that nobody has asked.
        say(answer * 2 if mode == "eager" else answer)
