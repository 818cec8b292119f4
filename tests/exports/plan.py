"""Solves exported planning problems with CommonRoad's reactive planner, and gives the solutions to CommonRoad's checker:

    python tests/exports/plan.py FILE...

Packages: commonroad-io 2024.3, commonroad-drivability-checker 2025.4.0, commonroad-reactive-planner 2025.1. The checker looks for a solution of the
right problem that starts where it should, reaches the goal, stays on the road, touches nothing and is feasible for the kinematics of a car. The planner
samples, so it does not solve every problem; without a solution to half of them this program fails.
"""

import logging
import sys

import numpy as np
from commonroad.common.file_reader import CommonRoadFileReader
from commonroad_clcs.config import CLCSParams
from commonroad_dc.feasibility.solution_checker import SolutionCheckerException, valid_solution
from commonroad_route_planner.reference_path_planner import ReferencePathPlanner
from commonroad_route_planner.route_planner import RoutePlanner
from commonroad_rp.reactive_planner import ReactivePlanner
from commonroad_rp.utility.config import ReactivePlannerConfiguration
from commonroad_rp.utility.evaluation import create_full_solution_trajectory, create_planning_problem_solution
from commonroad_rp.utility.utils_coordinate_system import CoordinateSystem

HORIZON, EVERY = 2.5, 6  # s, ticks
SLOWEST, BEYOND = 5.0, 40.0  # m/s, m


def settings(scenario, problem, problems):
    made = ReactivePlannerConfiguration()
    made.planning.dt, made.planning.planning_horizon = scenario.dt, HORIZON
    made.planning.time_steps_computation = round(HORIZON / scenario.dt)
    made.sampling.d_min, made.sampling.d_max, made.sampling.max_deceleration_ratio = -0.8, 0.8, 0.4
    made.debug.multiproc, made.debug.logging_level = False, "CRITICAL"
    made.update(scenario=scenario, planning_problem=problem)
    made.planning_problem_set = problems
    return made


def reference(scenario, problem):
    """The route to the goal, and a straight line beyond it, since the planner looks further than the goal's lanelet."""
    routes = RoutePlanner(scenario.lanelet_network, problem, logging_level=logging.CRITICAL).plan_routes()
    line = ReferencePathPlanner(scenario.lanelet_network, problem, routes).plan_shortest_reference_path().reference_path
    ahead = (line[-1] - line[-3]) / np.linalg.norm(line[-1] - line[-3])
    return np.vstack([line] + [line[-1] + distance * ahead for distance in np.arange(1.0, BEYOND)])


def solve(path):
    """The steps to the goal, or why there is no valid solution."""
    scenario, problems = CommonRoadFileReader(path).open()
    ((_, problem),) = problems.planning_problem_dict.items()
    made = settings(scenario, problem, problems)
    planner = ReactivePlanner(made)
    place = CoordinateSystem(reference(scenario, problem), clcs_params=CLCSParams())
    checker = planner.collision_checker
    planner.reset(initial_state_cart=planner.x_0, collision_checker=checker, coordinate_system=place)
    planner.record_state_and_input(planner.x_0)
    last = problem.goal.state_list[0].time_step.end
    speed = max(problem.initial_state.velocity, SLOWEST)
    step, plan = 0, None
    while not planner.goal_reached():
        if step == last:
            return None, "not at the goal in time"
        if step % EVERY == 0:
            planner.set_desired_velocity(desired_velocity=speed, current_speed=max(planner.x_0.velocity, 0.01))
            plan = planner.plan()
            if plan is None:
                return None, f"no plan at step {step}"
        at = step % EVERY + 1
        trajectory, along, aside = plan
        planner.record_state_and_input(trajectory.state_list[at])
        planner.reset(
            initial_state_cart=planner.record_state_list[-1],
            initial_state_curv=(along[at], aside[at]),
            collision_checker=checker,
            coordinate_system=place,
        )
        step += 1
    driven = create_full_solution_trajectory(made, planner.record_state_list)
    solution = create_planning_problem_solution(made, driven, scenario, problem)
    assert solution.benchmark_id.split(":")[2] == str(scenario.scenario_id), solution.benchmark_id
    try:
        valid, _ = valid_solution(scenario, problems, solution)
    except SolutionCheckerException as error:
        return None, str(error)
    return (step, "") if valid else (None, "not feasible")


def main(files):
    logging.disable(logging.CRITICAL)
    solved = 0
    for path in files:
        steps, why = solve(path)
        solved += steps is not None
        print(f"{path}: {why or f'solved in {steps} steps'}")
    assert 2 * solved >= len(files), f"{solved} of {len(files)} problems are solved"
    print(f"reactive planner: {solved} of {len(files)} problems are solved, and the checker agrees")


if __name__ == "__main__":
    main(sys.argv[1:])
