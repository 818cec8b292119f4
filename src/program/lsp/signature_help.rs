use lsp_types::{Documentation, ParameterInformation, ParameterLabel, SignatureHelp, SignatureInformation};

use super::cursor::{Cursor, Place};
use super::hover::one_line;
use compile::Catalog;

/// The keys of the kind in whose parentheses the cursor is, and which of them is being written; none elsewhere.
pub fn signature_help(cursor: &Cursor, catalog: &Catalog) -> Option<SignatureHelp> {
    let signature = cursor.signature?;
    let mut kinds = catalog.forms.iter().flat_map(|form| &form.kinds);
    kinds.find(|kind| std::ptr::eq(*kind, signature))?;
    // Half a name is the first key that begins with it.
    let begins =
        |name: &str| signature.params.iter().position(|param| !name.is_empty() && param.name.starts_with(name));
    let named = |name: &str| signature.params.iter().position(|param| param.name == name).or_else(|| begins(name));
    let active = match cursor.place {
        Place::Value(param) => named(param.name),
        Place::Key => named(cursor.word),
        _ => None,
    };
    let keys: Vec<&str> = signature.params.iter().map(|param| param.name).collect();
    let parameters = signature.params.iter().map(|param| ParameterInformation {
        label: ParameterLabel::Simple(param.name.into()),
        documentation: Some(Documentation::String(format!("{}\n{}", one_line(param), param.doc))),
    });
    let information = SignatureInformation {
        label: format!("{}({})", signature.name, keys.join(", ")),
        documentation: Some(Documentation::String(signature.doc.into())),
        parameters: Some(parameters.collect()),
        active_parameter: None,
    };
    let active_parameter = active.and_then(|place| u32::try_from(place).ok());
    Some(SignatureHelp { signatures: vec![information], active_signature: Some(0), active_parameter })
}
