//! Other simulators: the form `world`.

use std::sync::Arc;

use super::grid::{Axis, Ground};
use super::lowering::{BuiltTown, Lowering};
use base::signature::{DeclarationId, Form, Keys, Value};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use world::av::NativeKeys;
use world::env::{BridgeKeys, EpisodeRule, ExternalWorld};

/// The word of our own simulator.
pub const HERE: &str = "here";

/// The form `world`.
pub fn form() -> Form {
    let doc = "Another simulator, in which an `evaluate` block runs its episodes, too: `worlds: [here, NAME]`. The same pedestrians walk there from the same starts.";
    Form::of_kinds("world", doc, vec![BridgeKeys::signature()])
}

/// A world in which episodes of a block happen: ours, or another simulator.
pub(crate) type WorldAxis = Option<Axis<Arc<ExternalWorld>>>;

impl Lowering<'_> {
    /// The worlds of a list; `None` after reporting what is wrong with one.
    pub fn worlds(&mut self, words: &[Value]) -> Option<Vec<WorldAxis>> {
        let mut world = |word: &Value| match word {
            Value::Reference(id) => Some(Some(self.external_world(*id)?)),
            _ => Some(None),
        };
        words.iter().map(&mut world).collect()
    }

    /// Another simulator; where the user allows programs, its own is started and asked what the simulator can do. `None` after reporting what is wrong.
    pub fn external_world(&mut self, id: DeclarationId) -> Option<Axis<Arc<ExternalWorld>>> {
        let declaration = self.program.get(id);
        let axis = |value| Axis { id, name: declaration.name.as_str().into(), value };
        if declaration.name == HERE {
            let message = format!("`{HERE}` is the name of the simulator of this program");
            self.said.push(diagnostics::contradiction(declaration.block.head, message).help("give it another name"));
            return None;
        }
        let known = self.shared.worlds.get(&id).into_iter().flatten();
        if let Some((_, world)) = known.clone().find(|(block, _)| *block == declaration.block) {
            return world.clone().map(axis);
        }
        let world = self.greeted(declaration);
        self.shared.worlds.entry(id).or_default().push((declaration.block.clone(), world.clone()));
        world.map(axis)
    }

    fn greeted(&mut self, declaration: &Declaration) -> Option<Arc<ExternalWorld>> {
        let (program, opener) = self.allowed_program(declaration)?;
        let Some(write_map) = self.catalog.map_writer.clone() else {
            let message = "other worlds need maps, and this program writes none".to_string();
            self.said.push(diagnostics::contradiction(declaration.block.head, message));
            return None;
        };
        let BridgeKeys { program: keys } = declaration.block.keys();
        match ExternalWorld::new(program, &keys, opener, write_map) {
            Ok(world) => {
                if let Some(abilities) = &world.abilities {
                    self.note_version(declaration, &abilities.version);
                }
                Some(Arc::new(world))
            }
            Err(fault) => {
                let place = declaration.block.place("command");
                self.said.push(diagnostics::unusable_command(place, &keys.command, &format!("it {fault}")));
                None
            }
        }
    }

    /// Whether the drivers of a block drive in its worlds, which have what the episodes need; reports what does not.
    pub fn worlds_fit(&mut self, block: &Block, worlds: &[WorldAxis], ground: &Ground, rule: &EpisodeRule) -> bool {
        let errors = self.said.len();
        for world in worlds.iter().flatten() {
            if ground.roles.has_cars() {
                let message = format!("the cast has further cars, and `{}` moves the car under test alone", world.name);
                self.said.push(diagnostics::contradiction(block.place("worlds"), message));
            }
            for town in &ground.towns {
                if let Err(reason) = world.value.map(&town.value.town) {
                    let message = format!("the map of `{}` cannot be given to `{}`: {reason}", town.name, world.name);
                    self.said.push(diagnostics::contradiction(block.place("worlds"), message));
                }
            }
            let Some(abilities) = &world.value.abilities else { continue };
            if rule.friction.is_some() && !abilities.friction {
                let message = format!("the episode sets the `friction` of the road, and `{}` has none", world.name);
                self.said.push(diagnostics::contradiction(block.place("worlds"), message));
            }
        }
        for (place, policy) in ground.policies.iter().enumerate() {
            let declaration = self.program.get(policy.id);
            let span = block.members("policies").get(place).copied().unwrap_or(block.head);
            if declaration.kind != NativeKeys::KIND {
                let asked = worlds.iter().flatten().filter_map(|world| Some((world, world.value.abilities.as_ref()?)));
                for (world, _) in asked.filter(|(_, abilities)| !abilities.controls) {
                    self.said.push(diagnostics::not_driven_by_ours(span, &policy.name, &world.name));
                }
                continue;
            }
            let NativeKeys { driver } = declaration.block.keys();
            for world in worlds {
                let Some(world) = world else {
                    self.said.push(diagnostics::native_here(span, &policy.name));
                    continue;
                };
                let Some(abilities) = &world.value.abilities else { continue };
                if !abilities.drivers.contains(&driver) {
                    let known = abilities.drivers.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                    let message = format!("`{}` has no driver `{driver}`", world.name);
                    let known = if known.is_empty() { "it has none".into() } else { format!("it has {known}") };
                    self.said.push(diagnostics::contradiction(span, message).help(known));
                    continue;
                }
                let has_lights = |town: &&Axis<BuiltTown>| !town.value.town.traffic_lights.is_empty();
                let lit: Vec<_> = ground.towns.iter().filter(has_lights).map(|town| town.name.to_string()).collect();
                if rule.traffic_lights && !abilities.lights && !lit.is_empty() {
                    self.said.push(diagnostics::blind_to_lights(span, &policy.name, &world.name, &lit.join("`, `")));
                }
                if !abilities.seeds {
                    self.said.push(diagnostics::unseeded(span, &policy.name, &world.name));
                }
            }
        }
        self.said[errors..].iter().all(|each| each.severity == base::diagnostic::Severity::Warning)
    }
}
