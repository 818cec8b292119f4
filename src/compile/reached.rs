use std::collections::BTreeSet;

use base::signature::{Arguments, DeclarationId, Value};
use lang::hir::{Block, Program};

/// A declaration and all that it refers to, directly or not.
pub(super) fn reached(program: &Program, from: DeclarationId) -> BTreeSet<DeclarationId> {
    let mut open = vec![from];
    let mut seen = BTreeSet::new();
    while let Some(id) = open.pop() {
        if seen.insert(id) {
            references(&program.get(id).block, &mut open);
        }
    }
    seen
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
