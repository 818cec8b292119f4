//! The files as written, and once for each combination of each matrix.

use std::collections::BTreeSet;

use super::Catalog;
use super::reached::reached;
use base::diagnostic::{Diagnostic, Severity, Sources};
use base::signature::DeclarationId;
use lang::hir::{ParamId, Program};
use lang::{Checked, Matrix, diagnostics};

/// The files checked with one combination of settings, and the campaigns that are run that way.
pub(super) struct Variant {
    /// The checked program.
    pub program: Program,
    /// The campaign that a matrix multiplies; `None` for the files as written.
    pub multiplied: Option<DeclarationId>,
    /// Campaigns that belong to other variants.
    pub left_out: BTreeSet<DeclarationId>,
    /// The combination, as `name = value`.
    pub settings: Vec<String>,
    /// Declarations without errors in this variant or an earlier one.
    pub faultless: BTreeSet<DeclarationId>,
}

/// Applies settings and checks the files, as written and with each combination of each matrix.
pub(super) fn understand(
    mut loaded: lang::Loaded,
    settings: &[lang::Setting],
    catalog: &Catalog,
    sources: &Sources,
) -> (Vec<Variant>, Vec<Diagnostic>) {
    let mut diagnostics = std::mem::take(&mut loaded.diagnostics);
    lang::declare_inline(&mut loaded, &catalog.forms, sources);
    diagnostics.extend(lang::apply(settings, &mut loaded));
    // Settings may have kinds, too.
    lang::declare_inline(&mut loaded, &catalog.forms, sources);
    let (mut matrices, said) = lang::matrices(&mut loaded, &catalog.forms, settings, sources);
    diagnostics.extend(said);
    lang::declare_inline_axes(&mut matrices, &mut loaded, &catalog.forms, sources);
    let variants = variants(&loaded, &matrices, catalog, sources, &mut diagnostics);
    (variants, diagnostics)
}

/// The files as written, and once for each combination of each matrix.
fn variants(
    loaded: &lang::Loaded,
    matrices: &[Matrix],
    catalog: &Catalog,
    sources: &Sources,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Variant> {
    let mut checked = Checked::new(&catalog.vocabulary);
    let mut check = |loaded: &lang::Loaded| {
        let (program, said) = lang::check(loaded, sources, &catalog.forms, &mut checked);
        diagnostics.extend(said);
        (program, checked.faultless().collect())
    };
    let (program, faultless) = check(loaded);
    let id = |matrix: &Matrix| program.place(matrix.declaration.0, matrix.declaration.1);
    let left_out = matrices.iter().map(id).collect();
    let ids: Vec<DeclarationId> = matrices.iter().map(id).collect();
    let mut variants = vec![Variant { program, multiplied: None, left_out, settings: Vec::new(), faultless }];
    let (mut said, mut idle) = (Vec::new(), Vec::new());
    for (matrix, id) in matrices.iter().zip(ids) {
        let mut needed: BTreeSet<String> = BTreeSet::new();
        for combination in &matrix.combinations {
            let mut copy = loaded.clone();
            said.extend(lang::apply(combination, &mut copy));
            let settings = combination.iter().map(|each| each.text(sources)).collect();
            let (program, faultless) = check(&copy);
            let params: BTreeSet<ParamId> =
                reached(&program, id).iter().flat_map(|each| &program.get(*each).params).copied().collect();
            let names = program.params.iter().filter(|param| params.contains(&param.id));
            needed.extend(names.map(|param| param.name.clone()));
            variants.push(Variant { program, multiplied: Some(id), left_out: BTreeSet::new(), settings, faultless });
        }
        let name = &variants[0].program.get(id).name;
        let axes = matrix.combinations.iter().take(1).flatten().map(|axis| &axis.path[0]);
        // A parameter that has no effect at all is reported where it is declared.
        let used = |name: &str| variants[0].program.params.iter().any(|param| param.name == name && param.used);
        let axes = axes.filter(|axis| used(&axis.text));
        idle.extend(
            axes.filter(|axis| !needed.contains(&axis.text))
                .map(|axis| diagnostics::idle_axis(axis.span, &axis.text, name)),
        );
    }
    diagnostics.extend(said);
    if diagnostics.iter().all(|each| each.severity == Severity::Warning) {
        diagnostics.extend(idle);
    }
    variants
}
