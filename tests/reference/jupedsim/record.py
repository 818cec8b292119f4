"""Walks of JuPedSim's social force model: a free walker, a corridor, and bottlenecks.

    pip install jupedsim==1.4.2
    python tests/reference/jupedsim/record.py >tests/reference/jupedsim/flow.csv

The model is that of Helbing, Farkas and Vicsek (2000) with JuPedSim's constants. All want to walk at 1.3 m/s along x.
"""

import jupedsim
from shapely import box, union_all

SPEED, RADIUS, TICK = 1.3, 0.25, 0.01


def walk(area, starts, goal, seconds):
    """The tracks of all, each a list of positions every 0.1 s until it is at the goal."""
    model = jupedsim.SocialForceModel()
    simulation = jupedsim.Simulation(model=model, geometry=area, dt=TICK)
    exit = simulation.add_exit_stage(goal)
    journey = simulation.add_journey(jupedsim.JourneyDescription([exit]))
    parameters = jupedsim.SocialForceModelAgentParameters
    tracks = {}
    for place in starts:
        agent = parameters(
            journey_id=journey, stage_id=exit, position=place, desired_speed=SPEED, radius=RADIUS
        )
        tracks[simulation.add_agent(agent)] = []
    for tick in range(round(seconds / TICK)):
        if tick % 10 == 0:
            for agent in simulation.agents():
                tracks[agent.id].append(agent.position)
        if simulation.agent_count() == 0:
            break
        simulation.iterate()
    return list(tracks.values())


def crossing(track, x):
    """When a track passes a line (s); None if it does not."""
    for number, (one, other) in enumerate(zip(track, track[1:])):
        if one[0] <= x < other[0]:
            return 0.1 * (number + (x - one[0]) / (other[0] - one[0]))
    return None


def grid(columns, rows, apart, aside, x):
    """Places in columns from x on, about the middle line (m)."""
    lines = [aside * (row - (rows - 1) / 2) for row in range(rows)]
    return [(x + apart * column, y) for column in range(columns) for y in lines]


def speed(tracks, low, high):
    times = [crossing(track, high) - crossing(track, low) for track in tracks]
    return sum((high - low) / time for time in times) / len(times)


def main():
    corridor = box(0, -1.5, 60, 1.5)
    goal = [(59, -1.5), (60, -1.5), (60, 1.5), (59, 1.5)]
    print("case,people,width_m,quantity,value")
    free = walk(corridor, [(1, 0)], goal, 60)
    print(f"free,1,3,speed_mps,{speed(free, 10, 40):.3f}")
    # Three abreast, every 2.5 m: 0.4 people a square metre.
    people = walk(corridor, grid(6, 3, 2.5, 0.9, 1), goal, 80)
    print(f"corridor,18,3,speed_mps,{speed(people, 20, 45):.3f}")
    for width in (1.0, 1.2, 1.6, 2.0):
        area = union_all([box(0, -3, 8, 3), box(8, -width / 2, 9, width / 2), box(9, -3, 14, 3)])
        goal = [(13, -3), (14, -3), (14, 3), (13, 3)]
        tracks = walk(area, grid(6, 5, 0.8, 0.8, 1.5), goal, 200)
        times = sorted(time for time in (crossing(track, 8.5) for track in tracks) if time is not None)
        # From the sixth to the twenty-fifth: neither the first rush nor the last ones.
        flow = 19 / (times[24] - times[5])
        print(f"bottleneck,{len(times)},{width},people_per_s,{flow:.3f}")


main()
