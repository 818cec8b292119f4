use std::f64::consts::TAU;

use roxmltree::Node;

use super::OpenDriveProblem;
use super::attributes::{Context, child, children, metres};
use super::budget::MAX_LENGTH;
use crate::geometry::Pose;
use crate::{Geometry, PlanView, Shape};

/// Maximum angle that a spiral may turn (rad). Its places cost as much time as it turns.
const MAX_TURN: f64 = 64.0;

/// Reads the reference line of a road; empty when there is no usable piece.
pub(super) fn read(context: &mut Context, road: Node) -> PlanView {
    let pieces = child(road, "planView").into_iter().flat_map(|view| children(view, "geometry"));
    PlanView::new(pieces.filter_map(|node| piece(context, node)).collect())
}

fn piece(context: &mut Context, node: Node) -> Option<Geometry> {
    let (x, y) = (context.number(node, "x")?, context.number(node, "y")?);
    let length = context.number(node, "length").filter(|length| *length > 0.0 && *length <= MAX_LENGTH)?;
    let s = context.number_or_zero(node, "s");
    let heading = context.number_or_zero(node, "hdg");
    if heading.abs() > 2.0 * TAU {
        context.warn(node, OpenDriveProblem::ManyTurns { heading: metres(heading) });
    }
    let shape = node.children().filter(Node::is_element).find_map(|form| shape(context, form));
    if shape.is_none() {
        context.warn(node, OpenDriveProblem::UnknownShape);
    }
    let shape = shape.map(|shape| match shape {
        Shape::Spiral(first, last) if first.abs().max(last.abs()) * length > MAX_TURN => {
            context.warn(node, OpenDriveProblem::Winding);
            Shape::Line
        }
        shape => shape,
    });
    let start = Pose::new(x, y, heading);
    Some(Geometry::new(s, start, length, shape.unwrap_or(Shape::Line)).with_heading(heading))
}

fn shape(context: &mut Context, node: Node) -> Option<Shape> {
    match node.tag_name().name() {
        "line" => Some(Shape::Line),
        "arc" => Some(Shape::Arc(context.number(node, "curvature")?)),
        "spiral" => Some(Shape::Spiral(context.number(node, "curvStart")?, context.number(node, "curvEnd")?)),
        "poly3" => Some(Shape::Poly3(context.coefficients(node, ["a", "b", "c", "d"]))),
        "paramPoly3" => Some(Shape::ParamPoly3 {
            u: context.coefficients(node, ["aU", "bU", "cU", "dU"]),
            v: context.coefficients(node, ["aV", "bV", "cV", "dV"]),
            // The standard's default is the share of the length.
            normalized: node.attribute("pRange") != Some("arcLength"),
        }),
        _ => None,
    }
}
