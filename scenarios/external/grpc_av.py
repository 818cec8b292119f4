"""A gRPC server as a driver: `python3 grpc_av.py HOST:PORT` calls its method /falsify.Driver/Step each tick. `--serve` is such a server, to begin with. Needs grpcio.

Request and answer are the JSON of the protocol as bytes: a server needs no .proto. One of yours with a .proto converts the dictionary to its messages in `asked`."""
import json, sys
from concurrent import futures
import grpc

METHOD, TIMEOUT = "/falsify.Driver/Step", 1.0  # s

def drive(world):
    """Follows the route and brakes for who is near: put your planner here."""
    import math
    ego, (x, y, _) = world["ego"], (world["route"] or [(0, 0, 0)])[:4][-1]
    turn = math.remainder(math.atan2(y - ego["y"], x - ego["x"]) - ego["yaw"], math.tau)
    near = any(math.dist((ego["x"], ego["y"]), (a["x"], a["y"])) < 12 for a in world["actors"])
    wanted = 0 if near or not world["route"] else world["speed_limit"]
    return {"id": world["id"], "acceleration": 3 * (wanted - ego["speed"]), "steer": max(-1, min(1, turn))}

def serve(address):
    step = lambda request, _: json.dumps({"actions": [drive(world) for world in json.loads(request)["worlds"]]}).encode()
    handlers = {"Step": grpc.unary_unary_rpc_method_handler(step)}
    server = grpc.server(futures.ThreadPoolExecutor(1))
    server.add_generic_rpc_handlers([grpc.method_handlers_generic_handler("falsify.Driver", handlers)])
    print("port", server.add_insecure_port(address), flush=True)
    server.start()
    server.wait_for_termination()

def asked(address):
    step = grpc.insecure_channel(address).unary_unary(METHOD)
    for line in sys.stdin:
        if json.loads(line)["type"] == "hello":
            print(json.dumps({"protocol": "falsify-av/1"}), flush=True)
        else:
            print(step(line.encode(), timeout=TIMEOUT, wait_for_ready=True).decode(), flush=True)

if sys.argv[1] == "--serve":
    serve(sys.argv[2])
else:
    asked(sys.argv[1])
