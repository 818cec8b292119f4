//! HIR → [`Plan`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::lowering::{BuiltTown, Lowering, MadeDriver, Shared};
use super::noting::Noting;
use super::plan::{Documented, NamedDriver, NamedTown, Plan};
use super::reached::{reached, reaches};
use super::variants::{Variant, understand};
use super::whole_plan::{forbid_equal_names, warn_of_unused};
use super::{Catalog, adversary, policy, spawn, town};
use base::diagnostic::{Diagnostic, Severity, Sources};
use base::signature::DeclarationId;
use episode::SpawnRule;
use lang::hir::{Block, Declaration, ParamId};
use lang::{Reader, Unreadable, diagnostics};
use road::geometry::Obstacles;

/// The result of compiling a set of files.
#[derive(Debug)]
pub struct Compiled {
    /// The plan to run; `None` if a diagnostic is an error.
    pub plan: Option<Plan>,
    /// The plan when its only errors are unsatisfiable spawns: use it to plot starts, never to run. `None` if there is a plan, and if
    /// there is any other error.
    pub unplaced: Option<Plan>,
    pub diagnostics: Vec<Diagnostic>,
}

/// The user's input in addition to the files.
#[derive(Debug, Clone, Default)]
pub struct Overrides {
    /// OpenDRIVE maps that replace the roads of towns; the objects that the scenario places beside them stay.
    pub maps: BTreeMap<String, PathBuf>,
    /// Values for parameters and keys: `name=value`.
    pub settings: Vec<String>,
    /// Whether the plan is only inspected and not run: its tasks have no names and no fingerprints.
    pub only_checked: bool,
}

/// Reads, checks and lowers files with everything that they import.
///
/// # Errors
/// The first named file that cannot be read, with the reason. Everything else is a diagnostic.
pub fn compile(
    paths: &[PathBuf],
    catalog: &Catalog,
    read: &dyn Reader,
    sources: &mut Sources,
) -> Result<Compiled, Unreadable> {
    compile_with(paths, &Overrides::default(), catalog, read, sources)
}

/// Like [`compile`], with options.
///
/// # Errors
/// As [`compile`].
pub fn compile_with(
    paths: &[PathBuf],
    overrides: &Overrides,
    catalog: &Catalog,
    read: &dyn Reader,
    sources: &mut Sources,
) -> Result<Compiled, Unreadable> {
    let loaded = lang::load(paths, read, sources)?;
    let (settings, unreadable) = lang::settings(&overrides.settings, sources);
    let (variants, mut diagnostics) = understand(loaded, &settings, catalog, sources);
    diagnostics.extend(unreadable);
    let is_error = |each: &Diagnostic| each.severity == Severity::Error;
    let mut shared = Shared::default();
    let read = &Noting::new(read, !overrides.only_checked);
    let mut plan = Plan::default();
    if diagnostics.iter().any(is_error) {
        if let Some(Variant { program, left_out, faultless, .. }) = variants.first() {
            let (maps, digests) = (&overrides.maps, BTreeMap::new());
            let said = &mut diagnostics;
            let mut lowering = Lowering { program, catalog, sources, read, maps, said, shared: &mut shared, digests };
            lowering.as_far_as_whole(faultless, left_out);
        }
        lang::once(&mut diagnostics);
        in_order(&mut diagnostics);
        return Ok(Compiled { plan: None, unplaced: None, diagnostics });
    }
    let mut said: Vec<Vec<Diagnostic>> = Vec::new();
    for variant in &variants {
        let (program, maps, digests) = (&variant.program, &overrides.maps, BTreeMap::new());
        let mut own = Vec::new();
        let mut lowering =
            Lowering { program, catalog, sources, read, maps, said: &mut own, shared: &mut shared, digests };
        lowering.variant(variant, &settings, &mut plan);
        said.push(own);
    }
    diagnostics.extend(of_variants(&variants, &said));
    plan.settings = settings.iter().map(|each| plan.reached_by(each.text(sources))).collect();
    if !overrides.only_checked {
        plan.campaigns.iter_mut().for_each(|campaign| campaign.name_runs(1));
    }
    let base = &variants.first().expect("the files as they are").program;
    let imported = |each: &&Arc<Declaration>| each.form == "campaign" && !base.roots.contains(&each.source);
    let named = |each: &Arc<Declaration>| (each.name.clone(), sources.get(each.source).path.clone());
    plan.imported_campaigns = base.declarations.iter().filter(imported).map(named).collect();
    forbid_equal_names(base, &plan, overrides.only_checked, &mut diagnostics);
    warn_of_unused(base, &shared.used, &mut diagnostics);
    // One mistake may be reported for many tasks.
    lang::once(&mut diagnostics);
    in_order(&mut diagnostics);
    let errors: Vec<&Diagnostic> = diagnostics.iter().filter(|each| is_error(each)).collect();
    let (plan, unplaced) = match errors.as_slice() {
        [] => (Some(plan), None),
        errors if errors.iter().all(|each| diagnostics::is_unplaceable(each)) => (None, Some(plan)),
        _ => (None, None),
    };
    Ok(Compiled { plan, unplaced, diagnostics })
}

/// What was said of each variant, with its combination where that is not said of all.
fn of_variants(variants: &[Variant], said: &[Vec<Diagnostic>]) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    for (variant, own) in variants.iter().zip(said) {
        let combination = format!("so it is with {}", variant.settings.join(", "));
        let is_of_all = |each: &Diagnostic| said.iter().all(|other| other.contains(each));
        let named = own.iter().cloned().map(|mut each| {
            if !variant.settings.is_empty() && !is_of_all(&each) {
                each.help.insert(0, combination.clone());
            }
            each
        });
        all.extend(named);
    }
    all
}

/// Sorts diagnostics by their places: file by file, line by line. The phases report them one after the other.
fn in_order(diagnostics: &mut [Diagnostic]) {
    diagnostics.sort_by_key(|each| (each.primary.span.source, each.primary.span.start));
}

impl Lowering<'_> {
    fn variant(&mut self, variant: &Variant, outside: &[lang::Setting], plan: &mut Plan) {
        let program = self.program;
        if variant.multiplied.is_none() {
            // Towns of the named files are built even when nothing uses them: a library of towns is checked that way.
            for declaration in program.of_form("town") {
                let built = self.town(declaration.id);
                plan.towns.extend(built.map(|built| NamedTown { name: declaration.name.clone(), town: built.town }));
            }
            for declaration in program.of_form("driver") {
                let made = self.policy(declaration.id).filter(|_| !declaration.is_inline);
                let (name, carries) = (declaration.name.clone(), self.shared.carried.get(&declaration.id).cloned());
                plan.drivers.extend(made.map(|made| NamedDriver { name, policy: made.policy, carries }));
            }
            for declaration in program.of_form("pedestrian") {
                let _ = self.controller(declaration.id);
            }
            for declaration in program.of_form("world") {
                let _ = self.external_world(declaration.id);
            }
            for declaration in program.of_form("spawn") {
                let _ = self.spawn_rule(declaration.id);
            }
            for declaration in program.of_form("body") {
                adversary::check(&declaration.block, self.said);
            }
        }
        for declaration in program.of_form("campaign") {
            let chosen =
                variant.multiplied.map_or(!variant.left_out.contains(&declaration.id), |id| id == declaration.id);
            if chosen {
                let mut campaign = self.campaign(declaration);
                campaign.name = named(&campaign.name, &variant.settings);
                campaign.docs.extend(variant.settings.iter().map(|setting| format!("With {setting}.")));
                let outside = outside.iter().filter(|setting| reaches(program, declaration.id, setting));
                let outside = outside.map(|setting| setting.text(self.sources));
                campaign.settings = outside.chain(variant.settings.iter().cloned()).collect();
                campaign.words = self.note_used(declaration.id);
                plan.campaigns.push(campaign);
            }
        }
    }

    /// Builds the valid parts if other parts have errors, only for their diagnostics: declarations that are
    /// valid and refer only to valid ones.
    fn as_far_as_whole(&mut self, faultless: &BTreeSet<DeclarationId>, left_out: &BTreeSet<DeclarationId>) {
        let program = self.program;
        let of_form = |form| program.of_form(form).filter(|each| reached(program, each.id).is_subset(faultless));
        of_form("town").for_each(|town| drop(self.town(town.id)));
        of_form("driver").for_each(|policy| drop(self.policy(policy.id)));
        of_form("pedestrian").for_each(|controller| drop(self.controller(controller.id)));
        of_form("world").for_each(|world| drop(self.external_world(world.id)));
        of_form("spawn").for_each(|spawn| drop(self.spawn_rule(spawn.id)));
        of_form("body").for_each(|adversary| adversary::check(&adversary.block, self.said));
        for campaign in of_form("campaign").filter(|campaign| !left_out.contains(&campaign.id)) {
            self.campaign(campaign);
        }
    }

    pub fn town(&mut self, id: DeclarationId) -> Option<BuiltTown> {
        let declaration = self.program.get(id);
        let known = self.shared.towns.get(&id).into_iter().flatten();
        if let Some((_, built)) = known.clone().find(|(block, _)| *block == declaration.block) {
            return built.clone();
        }
        let map = self.maps.get(&declaration.name).map(PathBuf::as_path);
        let built = town::lower(&self.catalog.towns, declaration, map, self.sources, self.read, self.said)
            .map(|town| BuiltTown { obstacles: Arc::new(Obstacles::new(&town.obstacles)), town: Arc::new(town) });
        self.shared.towns.entry(id).or_default().push((declaration.block.clone(), built.clone()));
        built
    }

    pub fn spawn_rule(&mut self, id: DeclarationId) -> Option<SpawnRule> {
        let declaration = self.program.get(id);
        spawn::lower(declaration, &self.catalog.vocabulary, self.sources, self.said)
    }

    pub fn policy(&mut self, id: DeclarationId) -> Option<MadeDriver> {
        let declaration = self.program.get(id);
        // A variant may change the declaration behind a name without changing the policy.
        let contents: Vec<Block> =
            reached(self.program, id).into_iter().map(|each| self.program.get(each).block.clone()).collect();
        let known = self.shared.policies.get(&id).into_iter().flatten();
        if let Some((_, made)) = known.clone().find(|(blocks, _)| *blocks == contents) {
            return made.clone();
        }
        let made = policy::lower(declaration, self);
        self.shared.policies.entry(id).or_default().push((contents, made.clone()));
        made
    }

    /// Records the declarations that a campaign uses; returns the documented ones.
    fn note_used(&mut self, campaign: DeclarationId) -> Vec<Documented> {
        let seen = reached(self.program, campaign);
        let used = self.program.declarations.iter().filter(|each| each.id != campaign && seen.contains(&each.id));
        let documented = |form, name: &String, docs: &[String]| {
            let (name, docs) = (name.clone(), docs.join(" "));
            (!docs.is_empty()).then_some(Documented { form, name, docs })
        };
        let behind: BTreeSet<ParamId> = seen.iter().flat_map(|id| &self.program.get(*id).params).copied().collect();
        let params = self.program.params.iter().filter(|param| behind.contains(&param.id));
        let params = params.filter_map(|param| documented("param", &param.name, &param.docs));
        let documented = params.chain(used.filter_map(|each| documented(each.form, &each.name, &each.docs))).collect();
        self.shared.used.extend(seen);
        documented
    }
}

/// The name of a campaign with settings, suitable for a folder.
fn named(name: &str, settings: &[String]) -> String {
    let plain = |setting: &String| -> String {
        let kept = setting.chars().filter(|c| !c.is_whitespace());
        kept.map(|c| if c.is_ascii_alphanumeric() || "=.-_".contains(c) { c } else { '_' }).collect()
    };
    let parts: Vec<String> = std::iter::once(name.to_string()).chain(settings.iter().map(plain)).collect();
    parts.join("-")
}
