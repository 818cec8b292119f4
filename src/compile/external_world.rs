//! Other simulators: the form `world`.

use std::sync::Arc;

use super::grid::{Axis, Ground};
use super::lowering::Lowering;
use base::diagnostic::{Diagnostic, Span};
use base::signature::{DeclarationId, Form, Keys, Value};
use episode::{BridgeKeys, EpisodeRule, ExternalWorld, HERE};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use road::Town;
use world::av::NativeKeys;

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
        let mut found: Vec<(Span, Misfit)> = Vec::new();
        for (place, policy) in ground.policies.iter().enumerate() {
            let declaration = self.program.get(policy.id);
            let native = (declaration.kind == NativeKeys::KIND).then(|| declaration.block.keys::<NativeKeys>().name);
            let span = block.members("drivers").get(place).copied().unwrap_or(block.head);
            for world in worlds {
                let staging = Staging {
                    world: world.as_ref().map(|world| (&*world.name, &*world.value)),
                    driver: (&policy.name, native.as_deref()),
                    towns: ground.towns.iter().map(|town| (&*town.name, &*town.value.town)).collect(),
                    has_cars: ground.roles.has_cars(),
                    rule,
                };
                let at = |misfit: Misfit| (if misfit.is_of_driver { span } else { block.place("worlds") }, misfit);
                for each in staging.misfits().into_iter().map(at) {
                    if !found.contains(&each) {
                        found.push(each);
                    }
                }
            }
        }
        let fits = found.iter().all(|(_, misfit)| !misfit.is_error);
        self.said.extend(found.into_iter().map(|(span, Misfit { is_error, message, help, .. })| {
            let said = match is_error {
                true => diagnostics::contradiction(span, message),
                false => Diagnostic::warning("never-applies", span, message),
            };
            if help.is_empty() { said } else { said.help(help) }
        }));
        fits
    }
}

/// A driver whose episodes are to happen in a simulator.
pub struct Staging<'a> {
    /// The other simulator with its name; `None` for ours.
    pub world: Option<(&'a str, &'a ExternalWorld)>,
    /// The driver, and of a driver of the other simulator its name there.
    pub driver: (&'a str, Option<&'a str>),
    pub towns: Vec<(&'a str, &'a Town)>,
    /// Whether the cast has further cars.
    pub has_cars: bool,
    pub rule: &'a EpisodeRule,
}

/// What keeps a driver from its episodes in a simulator, or what these lack there.
#[derive(Debug, PartialEq, Eq)]
pub struct Misfit {
    /// Whether the episodes cannot happen.
    pub is_error: bool,
    /// Whether another driver may fit.
    is_of_driver: bool,
    pub message: String,
    /// What to do, or what follows.
    pub help: String,
}

impl Staging<'_> {
    /// All that does not fit. What a simulator can do is known if its program was asked.
    pub fn misfits(&self) -> Vec<Misfit> {
        let mut found = Vec::new();
        let mut add = |is_error, is_of_driver, message: String, help: &str| {
            found.push(Misfit { is_error, is_of_driver, message, help: help.into() });
        };
        let Self { driver: (policy, native), towns, rule, .. } = self;
        let Some((world, simulator)) = self.world else {
            if native.is_some() {
                let message = format!("`{policy}` is a driver of another simulator, and these episodes happen in ours");
                let help =
                    "name that simulator: a `world` in `worlds` of the `evaluate` block, or `--world` of a recheck";
                add(true, true, message, help);
            }
            return found;
        };
        if self.has_cars {
            let message = format!("the cast has further cars, and `{world}` moves the car under test alone");
            add(true, false, message, "");
        }
        for (name, town) in towns {
            if let Err(reason) = simulator.map(town) {
                add(true, false, format!("the map of `{name}` cannot be given to `{world}`: {reason}"), "");
            }
        }
        let Some(abilities) = &simulator.abilities else { return found };
        if rule.friction.is_some() && !abilities.friction {
            let message = format!("the episode sets the `friction` of the road, and `{world}` has none");
            add(true, false, message, "");
        }
        let known = abilities.drivers.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let known = if known.is_empty() { "it has none".into() } else { format!("it has {known}") };
        match native {
            None if abilities.controls && abilities.pedal_delay > 0.0 => {
                let message = format!(
                    "the car of `{world}` follows its pedals up to {} s late, as it states",
                    abilities.pedal_delay
                );
                add(false, false, message, "a fault there may be one of its actuators");
            }
            None if abilities.controls => {}
            None => {
                let message = format!("`{policy}` cannot drive in `{world}`, whose cars only its own drivers drive");
                add(true, true, message, &format!("name a driver of the kind `native`; {known}"));
            }
            Some(driver) if abilities.drivers.iter().all(|own| own != driver) => {
                add(true, true, format!("`{world}` has no driver `{driver}`"), &known);
            }
            Some(_) => {
                let lit = towns.iter().filter(|(_, town)| !town.traffic_lights.is_empty());
                let lit: Vec<&str> = lit.map(|(name, _)| *name).collect();
                if rule.traffic_lights && !abilities.lights && !lit.is_empty() {
                    let lit = lit.join("`, `");
                    let message =
                        format!("`{policy}` does not see the traffic lights of `{lit}`: `{world}` does not show them");
                    let help = "`traffic_lights: false` in the `episode` switches them off for all drivers";
                    add(false, true, message, help);
                }
                if !abilities.seeds {
                    let message = format!("the seed of an episode does not reach `{policy}`: `{world}` takes none");
                    add(false, true, message, "an episode may not be the same when it is repeated");
                }
            }
        }
        found
    }
}
