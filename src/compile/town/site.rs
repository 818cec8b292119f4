use std::path::Path;

use base::diagnostic::{Diagnostic, Sources};
use lang::Reader;
use road::TownParts;

/// What the parts of a town are made from, and where mistakes are reported.
pub(super) struct Site<'a> {
    /// The map that replaces the roads, if there is one.
    pub map: Option<&'a Path>,
    pub sources: &'a Sources,
    pub read: &'a dyn Reader,
    pub said: &'a mut Vec<Diagnostic>,
}

/// The parts of a town, before the objects of its file are put in.
pub(super) struct Drawn {
    pub parts: TownParts,
    /// Half of the width of the widest street (m); infinite if that is unknown.
    pub half_width: f64,
}
