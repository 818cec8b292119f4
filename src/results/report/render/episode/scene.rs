use maud::{Markup, html};

use super::EpisodeView;
use super::narrative::BRAKING;
use crate::report::render::svg::{fine, line, px};
use crate::report::render::town::Scenery;
use episode::{Frame, RecordedActor};
use road::geometry::Point;

/// The scene of an episode from above, in metres, y down.
impl EpisodeView<'_> {
    /// The `viewBox` of the visible part.
    pub fn view_box(&self) -> String {
        let (low, size) = self.ground();
        format!("{} {} {} {}", fine(low.x), fine(-low.y - size.y), fine(size.x), fine(size.y))
    }

    /// The visible part of the town.
    pub fn draw_ground(&self) -> Markup {
        let ((low, size), town) = (self.ground(), &self.pair().scenario.town);
        html! {
            rect.ground x=(fine(low.x)) y=(fine(-low.y - size.y)) width=(fine(size.x)) height=(fine(size.y)) {}
            (Scenery::new(town).within(low, low + size).drawn())
        }
    }

    /// A bar of five metres in the corner.
    pub fn draw_scale(&self) -> Markup {
        let (low, size) = self.ground();
        let part = size.x * 0.01;
        let (x, y) = (low.x + 2.0 * part, -low.y - 2.0 * part);
        html! {
            path d={ "M" (fine(x)) " " (fine(y)) "h5" } class="bar" stroke-width=(fine(part * 0.5)) {}
            text.ink x=(fine(x + 5.0 + part)) y=(fine(y + part)) style={ "font-size:" (fine(part * 3.4)) "px" } { "5 m" }
        }
    }

    /// The drawn radius of the pedestrian (m): its true radius, but large enough to be visible.
    pub fn person_radius(&self) -> f64 {
        self.pair().body.radius.max(self.ground().1.x * 0.012)
    }

    /// The paths of both from the first shown tick to this one.
    pub fn draw_ways(&self, end: usize, opacity: f64) -> Markup {
        let way = |place: fn(&Frame) -> Point| {
            let shown = self.shown().take_while(|(tick, _)| *tick <= end);
            line(shown.map(|(_, frame)| place(frame)).map(|place| (place.x, -place.y)), 2)
        };
        let width = fine(self.ground().1.x * 0.006);
        html! {
            path.way stroke-width=(width) stroke-opacity=(opacity) d=(way(|frame| frame.ego.pose.position())) {}
            path.trail stroke-width=(width) stroke-opacity=(opacity) d=(way(|frame| frame.pedestrian.pose.position())) {}
        }
    }

    /// The line of sight as the `d` of a path.
    pub fn line_of_sight(&self, frame: &Frame) -> String {
        let (eye, person) = (self.pair().eye(frame), frame.pedestrian.pose.position());
        line([(eye.x, -eye.y), (person.x, -person.y)], 2)
    }

    /// The line of sight: dashed, and pale when an obstacle blocks it.
    pub fn draw_sight(&self, frame: &Frame) -> Markup {
        let class = if self.pair().in_sight(frame) { "sight" } else { "hidden" };
        html! { path class=(class) d=(self.line_of_sight(frame)) {} }
    }

    /// The other actors after a tick, pale, with the names of their roles.
    pub fn draw_others(&self, tick: usize) -> Markup {
        html! {
            @for other in self.pair().others() {
                @let (pose, _) = other.state(tick);
                @let at = format!("translate({} {}) rotate({})", fine(pose.x), fine(-pose.y), px(-pose.yaw.to_degrees()));
                g transform=(at) { (self.draw_other(&other)) }
            }
        }
    }

    /// Another actor at the origin, facing along x.
    pub fn draw_other(&self, other: &RecordedActor<'_>) -> Markup {
        let (length, width) = (other.half.x, other.half.y);
        html! {
            @if other.is_pedestrian() { circle.person r=(fine(self.person_radius() * 0.8)) fill-opacity=".55" {} } @else {
                rect.car x=(fine(-length)) y=(fine(-width)) width=(fine(2.0 * length)) height=(fine(2.0 * width)) rx=".3" fill-opacity=".45" {}
            }
            title { (other.name) }
        }
    }

    /// Both at their positions, and the others.
    pub fn draw_actors(&self, tick: usize) -> Markup {
        let frame = self.frame(tick);
        let (pose, place) = (&frame.ego.pose, frame.pedestrian.pose.position());
        let lamps = if frame.control.brake > BRAKING { "1" } else { "0" };
        let turned = px(-pose.yaw.to_degrees());
        html! {
            (self.draw_others(tick))
            g transform={ "translate(" (fine(pose.x)) " " (fine(-pose.y)) ") rotate(" (turned) ")" } {
                (self.draw_car(lamps, &html! {}))
            }
            circle.person cx=(fine(place.x)) cy=(fine(-place.y)) r=(fine(self.person_radius())) stroke-width=(fine(self.person_radius() * 0.25)) {}
        }
    }

    /// The car at the origin, facing along x, with the opacity of its brake lamps or the animation of it.
    pub fn draw_car(&self, lamps: &str, animation: &Markup) -> Markup {
        let vehicle = self.pair().blueprint;
        let (length, width) = (vehicle.half_length, vehicle.half_width);
        html! {
            rect.car x=(fine(-length)) y=(fine(-width)) width=(fine(2.0 * length)) height=(fine(2.0 * width)) rx=".45" {}
            rect.glass x=(fine(length * 0.25)) y=(fine(-width * 0.8)) width=".7" height=(fine(width * 1.6)) rx=".2" {}
            g.lamp opacity=(lamps) {
                (animation)
                @for side in [-width + 0.12, width - 0.62] { rect x=(fine(-length)) y=(fine(side)) width=".35" height=".5" {} }
            }
        }
    }
}
