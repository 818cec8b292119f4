//! HIR → [`Plan`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::plan::{NamedTown, Plan};
use super::{Catalog, town};
use crate::diagnostic::{Diagnostic, Severity, Sources};
use crate::geometry::Obstacles;
use crate::lang::hir::{Block, Declaration, Program};
use crate::lang::{self, Reader, codes};
use crate::road::Town;
use crate::signature::{Arguments, DeclarationId, Value};

/// What came of a set of files.
#[derive(Debug)]
pub struct Compiled {
    /// What is to be run; none when a diagnostic is an error.
    pub plan: Option<Plan>,
    /// Everything that is to be said.
    pub diagnostics: Vec<Diagnostic>,
}

/// Reads, checks and lowers files with all that they import.
///
/// # Errors
/// The first named file that cannot be read, with the reason. Everything else is a diagnostic.
pub fn compile(
    paths: &[PathBuf],
    catalog: &Catalog,
    read: &Reader,
    sources: &mut Sources,
) -> Result<Compiled, (PathBuf, std::io::Error)> {
    compile_with_maps(paths, &BTreeMap::new(), catalog, read, sources)
}

/// Does as [`compile`], with the roads of some towns taken from OpenDRIVE maps instead; what the scenario places beside
/// them is kept.
///
/// # Errors
/// As [`compile`].
pub fn compile_with_maps(
    paths: &[PathBuf],
    maps: &BTreeMap<String, PathBuf>,
    catalog: &Catalog,
    read: &Reader,
    sources: &mut Sources,
) -> Result<Compiled, (PathBuf, std::io::Error)> {
    let mut loaded = lang::load(paths, read, sources)?;
    let mut diagnostics = std::mem::take(&mut loaded.diagnostics);
    let (program, said) = lang::check(&loaded, sources, &catalog.forms, &catalog.vocabulary);
    diagnostics.extend(said);
    let is_error = |each: &Diagnostic| each.severity == Severity::Error;
    if diagnostics.iter().any(is_error) {
        return Ok(Compiled { plan: None, diagnostics });
    }
    let mut lowering =
        Lowering { program: &program, catalog, sources, read, maps, said: &mut diagnostics, towns: BTreeMap::new() };
    let plan = lowering.plan();
    lowering.warn_of_unused();
    // One mistake may show in many cells.
    lang::once(&mut diagnostics);
    let plan = (!diagnostics.iter().any(is_error)).then_some(plan);
    Ok(Compiled { plan, diagnostics })
}

/// A town with what stands in it, ready to be shared.
#[derive(Clone)]
pub(super) struct BuiltTown {
    pub town: Arc<Town>,
    pub obstacles: Arc<Obstacles>,
}

/// What every step of the way from HIR to plan needs.
pub(super) struct Lowering<'a> {
    pub program: &'a Program,
    pub catalog: &'a Catalog,
    pub said: &'a mut Vec<Diagnostic>,
    sources: &'a Sources,
    read: &'a Reader<'a>,
    maps: &'a BTreeMap<String, PathBuf>,
    towns: BTreeMap<DeclarationId, Option<BuiltTown>>,
}

impl Lowering<'_> {
    fn plan(&mut self) -> Plan {
        let program = self.program;
        // Towns of the named files are built even when nothing uses them: a library of towns is checked that way.
        let mut towns = Vec::new();
        for declaration in program.of_form("town") {
            let built = self.town(declaration.id);
            towns.extend(built.map(|built| NamedTown { name: declaration.name.clone(), town: built.town }));
        }
        self.forbid_equal_names();
        let campaigns = program.of_form("campaign").map(|campaign| self.campaign(campaign)).collect();
        Plan { campaigns, towns }
    }

    /// Campaigns of different files may share a name as far as the language goes, but their reports may not.
    fn forbid_equal_names(&mut self) {
        let mut seen: BTreeMap<&str, &Declaration> = BTreeMap::new();
        for campaign in self.program.of_form("campaign") {
            if let Some(first) = seen.insert(&campaign.name, campaign) {
                let (here, there) = (campaign.block.head, first.block.head);
                self.said.push(codes::duplicate_declaration(here, "campaign", &campaign.name, there));
            }
        }
    }

    pub fn town(&mut self, id: DeclarationId) -> Option<BuiltTown> {
        if let Some(built) = self.towns.get(&id) {
            return built.clone();
        }
        let declaration = self.program.get(id);
        let map = self.maps.get(&declaration.name).map(PathBuf::as_path);
        let built = town::lower(declaration, map, self.sources, self.read, self.said)
            .map(|town| BuiltTown { obstacles: Arc::new(Obstacles::new(&town.obstacles)), town: Arc::new(town) });
        self.towns.insert(id, built.clone());
        built
    }

    fn warn_of_unused(&mut self) {
        let program = self.program;
        let mut used: BTreeSet<DeclarationId> = BTreeSet::new();
        let mut open: Vec<DeclarationId> = program.of_form("campaign").map(|campaign| campaign.id).collect();
        // A file without a campaign is a library: nothing in it is unused.
        let with_campaign: BTreeSet<_> = program.of_form("campaign").map(|campaign| campaign.source).collect();
        while let Some(id) = open.pop() {
            if used.insert(id) {
                references(&program.get(id).block, &mut open);
            }
        }
        for declaration in &program.declarations {
            if with_campaign.contains(&declaration.source) && !used.contains(&declaration.id) {
                self.said.push(codes::unused(declaration.block.head, declaration.form, &declaration.name));
            }
        }
    }
}

fn references(block: &Block, found: &mut Vec<DeclarationId>) {
    let mut note = |arguments: &Arguments| {
        for (_, value) in arguments.iter() {
            match value {
                Value::Reference(id) => found.push(*id),
                Value::List(members) => found.extend(members.iter().filter_map(|member| match member {
                    Value::Reference(id) => Some(*id),
                    _ => None,
                })),
                _ => {}
            }
        }
    };
    note(&block.arguments);
    for child in &block.children {
        references(child, found);
    }
}
