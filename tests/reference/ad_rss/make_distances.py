"""Writes distances.csv: safe distances of RSS as Intel's ad-rss-lib computes them.

Install it with `pip install ad-rss==5.0.0` (Python 3.11). The program writes to standard output:

    python3 make_distances.py > distances.csv
"""

import warnings

warnings.simplefilter("ignore")
from ad_rss import physics, rss  # noqa: E402

ACTORS = {  # response, accel_max, brake_min, brake_max
    "car": (1.0, 3.5, 4.0, 8.0),
    "jrc": (0.75, 3.0, 6.0, 6.0),
    "bare": (0.5, 0.0, 8.0, 8.0),
    "pedestrian": (0.5, 2.0, 2.0, 4.0),
}
LATERAL = (1.0, 0.2, 0.8, 0.1)  # response, accel_max, brake_min, margin
FASTEST = 100.0


def state(figures, lateral, along=0.0, aside=0.0):
    response, accelerates, brakes, hardest = figures
    made = rss.core.RelativeObjectState()
    made.object_type = rss.world.ObjectType.OtherVehicle
    dynamics = made.dynamics
    dynamics.alpha_lon.accel_max = physics.Acceleration(accelerates)
    dynamics.alpha_lon.brake_min = physics.Acceleration(-brakes)
    dynamics.alpha_lon.brake_min_correct = physics.Acceleration(-brakes)
    dynamics.alpha_lon.brake_max = physics.Acceleration(-hardest)
    dynamics.alpha_lat.accel_max = physics.Acceleration(lateral[1])
    dynamics.alpha_lat.brake_min = physics.Acceleration(-lateral[2])
    dynamics.lateral_fluctuation_margin = physics.Distance(lateral[3])
    dynamics.response_time = physics.Duration(response)
    dynamics.max_speed_on_acceleration = physics.Speed(FASTEST)
    dynamics.min_longitudinal_safety_distance = physics.Distance(0.0)
    settings = dynamics.unstructured_settings
    settings.pedestrian_turning_radius = physics.Distance(2.0)
    settings.drive_away_max_angle = physics.Angle(2.4)
    settings.vehicle_yaw_rate_change = physics.AngularAcceleration(0.3)
    settings.vehicle_min_radius = physics.Distance(3.5)
    settings.vehicle_trajectory_calculation_step = physics.Duration(0.2)
    # Not used by these formulas, but checked by the library.
    unstructured = made.unstructured_object_state
    unstructured.yaw = physics.Angle(0.0)
    unstructured.yaw_rate = physics.AngularVelocity(0.0)
    unstructured.steering_angle = physics.Angle(0.0)
    unstructured.dimension.length = physics.Distance(4.0)
    unstructured.dimension.width = physics.Distance(2.0)
    unstructured.center_point.x = unstructured.center_point.y = physics.Distance(0.0)
    unstructured.speed_range.minimum = unstructured.speed_range.maximum = physics.Speed(0.0)
    structured = made.structured_object_state
    structured.is_in_correct_lane = True
    structured.has_priority = False
    structured.distance_to_enter_intersection = physics.Distance(1000.0)
    structured.distance_to_leave_intersection = physics.Distance(1000.0)
    velocity = structured.velocity
    velocity.speed_lon_min = velocity.speed_lon_max = physics.Speed(along)
    velocity.speed_lat_min = velocity.speed_lat_max = physics.Speed(aside)
    return made


def computed(function, first, second):
    distance = physics.Distance(0.0)
    assert function(first, second, distance), "ad-rss refuses the input"
    return distance / physics.Distance(1.0)


def main():
    print("# ad-rss 5.0.0: safe distances (m) for speeds (m/s); lateral speeds are positive to the right")
    print("formula,limits,first,second,distance")
    following = rss.structured.calculateSafeLongitudinalDistanceSameDirection
    beside = rss.structured.calculateSafeLateralDistance
    for name, figures in ACTORS.items():
        for behind in (0.0, 1.4, 2.78, 5.0, 8.33, 13.89, 16.67, 30.0):
            for ahead in (0.0, 1.39, 5.0, 8.33, 16.67):
                far = computed(following, state(figures, LATERAL, ahead), state(figures, LATERAL, behind))
                print(f"longitudinal,{name},{behind},{ahead},{far:.6f}")
    figures = (LATERAL[0], 3.5, 4.0, 8.0)
    for left in (-3.0, -1.0, -0.1, 0.0, 0.1, 0.5, 1.39, 3.0):
        for right in (-3.0, -1.39, -0.5, -0.1, 0.0, 0.1, 0.5, 1.0, 1.05, 3.0):
            far = computed(beside, state(figures, LATERAL, 5.0, left), state(figures, LATERAL, 5.0, right))
            print(f"lateral,car,{left},{right},{far:.6f}")


main()
