"""An FMU (FMI 2.0, co-simulation) as a driver: `python3 fmu_av.py brake.fmu`. It brakes; a follower of the route drives and steers. Needs FMPy."""
import json, math, os, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

SPEED, GAP, CLOSING, LEFT, KIND, BRAKE = ["ego_speed", "object_distance", "object_closing", "object_lateral", "object_class", "brake"]
NOBODY, PEDESTRIAN, CAR = 0, 2, 1
out = os.fdopen(os.dup(1), "w")  # what the FMU prints is no answer
os.dup2(2, 1)
model, folder = read_model_description(sys.argv[1]), extract(sys.argv[1])
reference = {each.name: each.valueReference for each in model.modelVariables}
step = float(model.defaultExperiment.stepSize or 0.05)
units = {}  # one for each world

def begin(world):
    """Makes a new instance: many cannot be reset."""
    if world in units:
        units.pop(world).freeInstance()
    unit = units[world] = FMU2Slave(guid=model.guid, unzipDirectory=folder, modelIdentifier=model.coSimulation.modelIdentifier, instanceName=f"world {world}")
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()

def drive(world, car, tick):
    ego, route = world["ego"], world["route"] or [[0, 0, 0]]
    if "seed" in world:
        begin(world["id"])
    unit = units[world["id"]]
    sin, cos = math.sin(ego["yaw"]), math.cos(ego["yaw"])
    local = lambda x, y: (cos * (x - ego["x"]) + sin * (y - ego["y"]), cos * (y - ego["y"]) - sin * (x - ego["x"]))
    seen = [(*local(a["x"], a["y"]), a) for a in world["actors"]]
    ahead = [(x - (car["length"] + a["length"]) / 2, y, a) for x, y, a in seen if x > 0 and abs(y) < (car["width"] + a["width"]) / 2]
    gap, left, actor = min(ahead, key=lambda each: each[0], default=(200.0, 0.0, None))
    closing = ego["speed"] - (cos * actor["vx"] + sin * actor["vy"]) if actor else 0.0
    kind = NOBODY if actor is None else PEDESTRIAN if actor["kind"] == "pedestrian" else CAR
    unit.setReal([reference[each] for each in (SPEED, GAP, CLOSING, LEFT)], [3.6 * ego["speed"], max(gap, 0.0), closing, left])  # this FMU wants km/h
    unit.setInteger([reference[KIND]], [kind])
    for number in range(round(tick / step)):
        unit.doStep(currentCommunicationPoint=world["tick"] * tick + number * step, communicationStepSize=step)
    braking, (x, y) = unit.getReal([reference[BRAKE]])[0], local(*route[:4][-1][:2])
    wanted = 2 * (0.9 * world["speed_limit"] - ego["speed"]) if world["route"] else -2.0
    turn, most = math.atan2(2 * car["wheelbase"] * y, x * x + y * y) if world["route"] else 0.0, car["greatest_wheel_angle"]
    return {"id": world["id"], "acceleration": -braking if braking > 0 else min(wanted, 2.0), "wheel_angle": max(-most, min(most, turn))}

for message in map(json.loads, sys.stdin):
    hello = message if message["type"] == "hello" else hello
    actions = [drive(world, hello["vehicle"], hello["tick_s"]) for world in message.get("worlds", [])] if message is not hello else None
    print(json.dumps({"protocol": "falsify-av/1"} if actions is None else {"actions": actions}), file=out, flush=True)
