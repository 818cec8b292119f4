//! Words with their roles, for colours that depend on what a word means: a key, a kind, a name that is declared.

use std::collections::BTreeSet;

use lsp_types::{SemanticToken, SemanticTokenModifier, SemanticTokenType};

use super::cursor::{Place, places};
use super::hover::referred;
use super::references::declared_names;
use super::visible::Visible;
use base::diagnostic::Lines;
use compile::Catalog;
use lang::{ast, functions, temporal_operators};

/// The types of words, in the order of their numbers.
pub const TYPES: [SemanticTokenType; 9] = [
    SemanticTokenType::KEYWORD,
    SemanticTokenType::CLASS,
    SemanticTokenType::PROPERTY,
    SemanticTokenType::VARIABLE,
    SemanticTokenType::PARAMETER,
    SemanticTokenType::FUNCTION,
    SemanticTokenType::ENUM_MEMBER,
    SemanticTokenType::EVENT,
    SemanticTokenType::TYPE,
];
/// What else is known of a word, in the order of the bits.
pub const MODIFIERS: [SemanticTokenModifier; 1] = [SemanticTokenModifier::DECLARATION];

/// The words of a text whose role is known, each relative to the one before it. Units, numbers and comments have the colours of the grammar.
pub fn semantic_tokens(root: &ast::File, text: &str, visible: Visible, catalog: &Catalog) -> Vec<SemanticToken> {
    let own: BTreeSet<usize> = declared_names(root).map(|(name, _)| name.span.start).collect();
    let params: BTreeSet<&str> = visible.params().map(|param| param.name.text.as_str()).collect();
    let names: BTreeSet<&str> =
        visible.declarations().filter_map(|each| Some(each.name.as_ref()?.text.as_str())).collect();
    let named = |word: &str| {
        let is_param = params.contains(word).then_some(SemanticTokenType::PARAMETER);
        is_param.or_else(|| names.contains(word).then_some(SemanticTokenType::VARIABLE))
    };
    let role = |word: &str, place: &Place| match place {
        Place::Form => Some(SemanticTokenType::KEYWORD),
        Place::Kind(_) => Some(SemanticTokenType::CLASS),
        Place::Key => Some(SemanticTokenType::PROPERTY),
        Place::Event => Some(SemanticTokenType::EVENT),
        Place::EventWord(_) => Some(SemanticTokenType::ENUM_MEMBER),
        Place::Type => Some(SemanticTokenType::TYPE),
        Place::Param | Place::Axis => Some(SemanticTokenType::PARAMETER),
        Place::Imported(_) | Place::ParamValue { .. } | Place::AxisValue(_) => named(word),
        Place::Value(param) if referred(&param.ty).is_some() => named(word),
        Place::Value(_) | Place::Formula if functions().chain(temporal_operators()).any(|(name, _)| name == word) => {
            Some(SemanticTokenType::FUNCTION)
        }
        Place::Value(_) | Place::Formula if params.contains(word) => Some(SemanticTokenType::PARAMETER),
        Place::Value(_) | Place::Formula if catalog.vocabulary.variables.iter().any(|each| each.name == word) => {
            Some(SemanticTokenType::VARIABLE)
        }
        Place::Value(_) => Some(SemanticTokenType::ENUM_MEMBER),
        _ => None,
    };
    let lines = Lines::new(text);
    let (mut tokens, mut last) = (Vec::new(), (0, 0));
    for (span, place) in places(text, catalog) {
        let word = &text[span.clone()];
        let is_declared = own.contains(&span.start);
        let found = match is_declared {
            true => named(word),
            false if lang::tokens::KEYWORDS.contains(&word) => Some(SemanticTokenType::KEYWORD),
            false => role(word, &place),
        };
        let Some(number) = found.and_then(|found| TYPES.iter().position(|each| *each == found)) else { continue };
        let (line, start) = lines.utf16(span.start);
        tokens.push(SemanticToken {
            delta_line: line - last.0,
            delta_start: if line == last.0 { start - last.1 } else { start },
            length: word.len() as u32,
            token_type: number as u32,
            token_modifiers_bitset: u32::from(is_declared),
        });
        last = (line, start);
    }
    tokens
}
