# A maneuver for openpilot's own tests, selfdrive/test/longitudinal_maneuvers: a lead that is there from
# the tick on in which the person is in the path of the car.
from openpilot.selfdrive.test.longitudinal_maneuvers.maneuver import Maneuver

MANEUVER = Maneuver(
  'a person steps into the path of the car',
  duration=4.85,
  initial_speed=8.34,
  lead_relevancy=True,
  initial_distance_lead=35.0,
  speed_lead_values=[-1.38, -1.38, -1.38, -1.38],
  prob_lead_values=[0.0, 0.0, 1.0, 1.0],
  cruise_values=[8.34, 8.34, 8.34, 8.34],
  breakpoints=[0.0, 2.525, 2.55, 4.85],
  personality=1,
)
