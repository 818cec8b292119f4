//! Checks that need all files together: names of reports, and declarations without effect.

use std::collections::{BTreeMap, BTreeSet};

use super::plan::Plan;
use base::diagnostic::Diagnostic;
use base::signature::DeclarationId;
use lang::diagnostics;
use lang::hir::{Declaration, Program};

/// The longest name of a combination (bytes); folders and files get this name.
const MAX_CAMPAIGN_NAME: usize = 150;

/// Reports campaigns of different files with the same name. The language allows them, but their reports would collide; files that are only checked
/// have none.
pub(super) fn forbid_equal_names(program: &Program, plan: &Plan, only_checked: bool, said: &mut Vec<Diagnostic>) {
    let mut seen: BTreeMap<&str, &Declaration> = BTreeMap::new();
    for campaign in program.of_form("campaign") {
        if let Some(first) = seen.insert(&campaign.name, campaign)
            && !only_checked
        {
            let (here, there) = (campaign.block.head, first.block.head);
            said.push(diagnostics::duplicate_declaration(here, "campaign", &campaign.name, there));
        }
    }
    let (mut names, distinct) = (BTreeSet::new(), seen.len() == program.of_form("campaign").count());
    for campaign in &plan.campaigns {
        if campaign.name.len() > MAX_CAMPAIGN_NAME {
            let source = program.of_form("campaign").find(|each| campaign.name.starts_with(&each.name));
            let head = source.expect("a campaign is made from a declaration").block.head;
            said.push(diagnostics::long_combination(head, &campaign.name, MAX_CAMPAIGN_NAME));
            return;
        }
        if distinct && !names.insert(&campaign.name) {
            let source = program.of_form("campaign").find(|each| campaign.name.starts_with(&each.name));
            let head = source.expect("a campaign is made from a declaration").block.head;
            said.push(diagnostics::contradiction(
                head,
                format!("two combinations would both be named `{}`", campaign.name),
            ));
        }
    }
}

/// Warns of declarations and parameters without effect, in files that hold a campaign.
pub(super) fn warn_of_unused(program: &Program, used: &BTreeSet<DeclarationId>, said: &mut Vec<Diagnostic>) {
    // A file without a campaign is a library, in which no declaration counts as unused.
    let with_campaign: BTreeSet<_> = program.of_form("campaign").map(|campaign| campaign.source).collect();
    for declaration in &program.declarations {
        let counts = with_campaign.contains(&declaration.source) && !declaration.is_inline;
        if counts && !used.contains(&declaration.id) {
            said.push(diagnostics::unused(declaration.block.head, declaration.form, &declaration.name));
        }
    }
    for param in &program.params {
        if with_campaign.contains(&param.id.0) && !param.used {
            said.push(diagnostics::unused(param.span, "param", &param.name));
        }
    }
}
