use base::signature::{Held, Plain, Type, Value};
use road::Town;
use road::geometry::Point;

/// Where a pedestrian is on its way to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Destination {
    /// This place.
    Point(Point),
    /// The bus stop of its town that is the nearest to its start.
    BusStop,
}

impl Destination {
    /// Its place in a town for a pedestrian that starts somewhere; `None` in a town without bus stops.
    pub fn place(self, town: &Town, start: Point) -> Option<Point> {
        match self {
            Self::Point(place) => Some(place),
            Self::BusStop => {
                let apart = |stop: &Point| (stop - start).norm_squared();
                town.bus_stops.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)))
            }
        }
    }
}

impl Held for Destination {
    fn held(value: &Value) -> Option<Self> {
        match value {
            Value::Point(x, y) => Some(Self::Point(Point::new(*x, *y))),
            Value::Choice(_) => Some(Self::BusStop),
            _ => None,
        }
    }
}

impl Plain for Destination {
    fn single() -> Type {
        Type::WordOrPoint(&["bus_stop"])
    }
}
