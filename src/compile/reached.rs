use std::cell::RefCell;
use std::collections::BTreeSet;

use base::signature::{Arguments, DeclarationId, Formula, Value};
use episode::robustness_of;
use lang::Setting;
use lang::hir::{Block, ParamId, Program};

/// A declaration and all that it refers to, directly or not.
pub(super) fn reached(program: &Program, from: DeclarationId) -> BTreeSet<DeclarationId> {
    all_from(program, vec![from])
}

/// All that a block refers to, directly or not.
pub(super) fn reached_by(program: &Program, block: &Block) -> BTreeSet<DeclarationId> {
    let mut open = Vec::new();
    references(block, &mut open);
    all_from(program, open)
}

fn all_from(program: &Program, mut open: Vec<DeclarationId>) -> BTreeSet<DeclarationId> {
    let mut seen = BTreeSet::new();
    while let Some(id) = open.pop() {
        if seen.insert(id) {
            references(&program.get(id).block, &mut open);
        }
    }
    seen
}

/// Whether a declaration depends on what a setting from outside the files changes: a parameter, or a key of a declaration.
pub(super) fn reaches(program: &Program, from: DeclarationId, setting: &Setting) -> bool {
    let seen = reached(program, from);
    let mut declarations = seen.iter().map(|id| program.get(*id));
    match setting.path.as_slice() {
        [name] => {
            let named = |id: &ParamId| program.params.iter().any(|param| param.id == *id && param.name == name.text);
            declarations.any(|each| each.params.iter().any(named))
        }
        [first, next, ..] => {
            declarations.any(|each| each.name == first.text || (each.form == first.text && each.name == next.text))
        }
        [] => false,
    }
}

/// The requirements of which a formula names the robustness.
pub(super) fn requirements_in(formula: &Formula, found: &mut Vec<DeclarationId>) {
    let named = RefCell::new(Vec::new());
    formula.mentions(&|id| {
        named.borrow_mut().extend(robustness_of(id).map(DeclarationId));
        false
    });
    found.extend(named.into_inner());
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
    let formulas = block.clauses.iter().map(|clause| &clause.formula);
    let given = block.arguments.iter().filter_map(|(_, value)| match value {
        Value::Formula(formula) => Some(formula),
        _ => None,
    });
    found.extend(block.clauses.iter().filter_map(|clause| clause.subject));
    formulas.chain(given).for_each(|formula| requirements_in(formula, found));
    for child in &block.children {
        references(child, found);
    }
}
