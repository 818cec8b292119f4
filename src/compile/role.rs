use std::sync::Arc;

use super::lowering::{Lowering, MadeDriver};
use super::reached::reached;
use super::requirement::RequirementKeys;
use base::diagnostic::Span;
use base::signature::{
    ActorSignal, Comparison, DeclarationId, Distribution, Form, Formula, Function, Keys, Requirement, Value, VariableId,
};
use base::{choice, keys};
use episode::requirement::NamedRequirement;
use episode::walker::{self, Scripted};
use episode::{Cast, Controller, PedestrianRole, Placement, PolicyMaker, SpawnRule, VehicleRole};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use world::av::{Cruise, CruiseKeys};
use world::sim::{ActorId, VehicleBlueprint};

/// The word of the car under test, and that of a pedestrian that stands.
const EGO: &str = "ego";
const STILL: &str = "still";

keys! {
    /// A pedestrian beside others. Without `spawn`, `beside` and `ahead_of` the spawn rule of the campaign or of the block places it; so it does at
    /// least the first.
    pub struct PedestrianKeys = "pedestrian" {
        /// Its body, instead of the campaign's.
        body: Option<DeclarationId> as Reference("body"),
        // The catalogue adds the words of the others.
        /// What moves it: a kind of pedestrian, a `pedestrian` of the file, or nothing (`still`). Without the key the blocks of the campaign do:
        /// their trainings, pedestrians and searches.
        moved_by: Option<Value> as WordOrReference(vec![STILL], "pedestrian"),
        /// The number of such pedestrians, each placed for itself.
        count: u32 as whole(1, 50) = "1",
        /// The spawn rule in whose sector about the ego it begins. What the rule says of the ego does not count.
        spawn: Option<DeclarationId> as Reference("spawn"),
        /// The role beside which it begins, in any direction, or `ego`.
        beside: Option<Value> as WordOrReference(vec![EGO], "role"),
        /// The role ahead of which it begins, or `ego`.
        ahead_of: Option<Value> as WordOrReference(vec![EGO], "role"),
        /// Its distance from the role in `beside` or `ahead_of`, from body to body.
        distance: Distribution as drawn(LENGTH, 0.0, 200.0) = "0.5 m .. 2 m",
        /// How far it is to the left of the axis of the role in `ahead_of`.
        aside: Distribution as drawn(LENGTH, -50.0, 50.0) = "0 m",
    }
}

keys! {
    /// A car beside the car under test.
    pub struct CarKeys = "vehicle" {
        /// Its model, instead of the campaign's `vehicle`.
        vehicle: Option<DeclarationId> as Reference("vehicle"),
        /// Its driver. Without one it is parked: it hides what is behind it, and pedestrians walk around it.
        driver: Option<DeclarationId> as Reference("driver"),
        /// The car behind which it drives at the start of the episode, as fast as it.
        behind: Option<Leader>,
        /// Its time gap to the bumper of that car; at least 2 m.
        gap: Distribution as drawn(TIME, 0.0, 60.0) = "1 s .. 2 s",
        /// The role ahead of which it begins, or `ego`, unless it drives `behind` one.
        ahead_of: Value as WordOrReference(vec![EGO], "role") = "ego",
        /// Its distance from that role, from body to body.
        distance: Distribution as drawn(LENGTH, 0.0, 200.0) = "10 m .. 30 m",
        /// How far it is to the left of the middle of the lane there.
        aside: Distribution as drawn(LENGTH, -50.0, 50.0) = "0 m",
    }
}

choice! {
    /// The car that another one follows.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Leader {
        Ego = "ego",
    }
}

/// The form `role`.
pub fn form() -> Form {
    let doc = "An actor beside the car under test, for the `cast` of a campaign. There it can be declared in place: `cast { child: pedestrian(moved_by: natural, beside: friend) }`.";
    Form::of_kinds("role", doc, vec![PedestrianKeys::signature(), CarKeys::signature()])
}

/// The actors of a campaign; empty for one car and one pedestrian.
#[derive(Default)]
pub(crate) struct Roles {
    pub ids: Vec<DeclarationId>,
    cars: Vec<Car>,
    /// The first is the one that the spawn rule places.
    pedestrians: Vec<Walking>,
    /// The actors of each role; more than one of a group.
    actors: Vec<(DeclarationId, Vec<ActorId>)>,
}

struct Car {
    name: Arc<str>,
    model: Option<VehicleBlueprint>,
    /// `None` if it is parked.
    driver: Option<MadeDriver>,
    place: Placement,
}

#[derive(Clone)]
struct Walking {
    name: Arc<str>,
    adversary: Option<PedestrianRole>,
    controller: Controller,
    /// `None` if the spawn rule of the block places it.
    place: Option<Placement>,
}

impl Roles {
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    pub fn has_cars(&self) -> bool {
        !self.cars.is_empty()
    }

    /// The cast with this ego and this pedestrian of the campaign, where this rule places those without a place of their own.
    pub fn cast(&self, ego: VehicleRole, usual: &PedestrianRole, spawn: &SpawnRule) -> Cast {
        if self.is_empty() {
            return Cast::pair(ego, usual.clone());
        }
        let parked: PolicyMaker = Arc::new(|| Box::new(Cruise::new(CruiseKeys::default())));
        let cars = self.cars.iter().map(|car| {
            let made =
                car.driver.clone().unwrap_or_else(|| MadeDriver { policy: parked.clone(), parts: Arc::default() });
            VehicleRole {
                name: car.name.clone(),
                blueprint: car.model.clone().unwrap_or_else(|| ego.blueprint.clone()),
                policy: made.policy,
                parts: made.parts,
                is_parked: car.driver.is_none(),
                is_absent: false,
                place: car.place.clone(),
            }
        });
        let cars: Vec<VehicleRole> = cars.collect();
        let around = Placement::Sector(Arc::new(spawn.clone()));
        let pedestrians = self.pedestrians.iter().enumerate().map(|(number, each)| PedestrianRole {
            name: each.name.clone(),
            controller: each.controller.clone(),
            place: each.place.as_ref().unwrap_or(if number == 0 { &Placement::Spawn } else { &around }).clone(),
            ..each.adversary.clone().unwrap_or_else(|| usual.clone())
        });
        let pedestrians = pedestrians.collect();
        Cast { vehicles: std::iter::once(ego).chain(cars).collect(), pedestrians }
    }

    /// The actors of a role by its number in signals: 0 for the car under test. `None` if it is not in the cast.
    fn actors(&self, role: usize) -> Option<&[ActorId]> {
        let Some(id) = role.checked_sub(1) else { return Some(&[ActorId::EGO]) };
        self.actors.iter().find(|(own, _)| own.0 == id).map(|(_, actors)| actors.as_slice())
    }

    /// Requirements whose signals name actors instead of roles.
    pub fn resolved(&self, requirements: &Arc<[NamedRequirement]>) -> Arc<[NamedRequirement]> {
        if self.is_empty() {
            return requirements.clone();
        }
        let mut actors = |id: VariableId| {
            let Some(ActorSignal { of, to, signal }) = id.of_actor() else { return vec![id] };
            // A role that is not in the cast has been reported.
            let all = |role| self.actors(role).unwrap_or(&[ActorId::EGO]).iter();
            // The members of a group towards each other.
            let is_group = of == to && all(of).len() > 1;
            let pairs = all(of).flat_map(|of| all(to).map(move |to| (of, to)));
            let pairs = pairs.filter(|(of, to)| !is_group || of != to);
            pairs.map(|(of, to)| ActorSignal { of: of.code(), to: to.code(), signal }.into()).collect()
        };
        let resolved = requirements.iter().map(|each| {
            let own = &*each.requirement;
            let parts = own.parts.iter();
            let parts = parts.map(|part| Comparison { margin: part.margin.substituted(&mut actors), ..part.clone() });
            let requirement = Requirement { parts: parts.collect(), formula: own.formula.clone() };
            NamedRequirement { requirement: Arc::new(requirement), ..each.clone() }
        });
        resolved.collect()
    }

    /// Whether the spawn rule of a block places more than one pedestrian.
    pub fn shares_spawn(&self) -> bool {
        self.pedestrians.iter().filter(|each| each.place.is_none()).count() > 1
    }

    /// How many numbers the state of each pedestrian has that the campaign's controllers move, if its pedestrian is this one.
    pub fn states(&self, usual: &PedestrianRole) -> Vec<usize> {
        match self.is_empty() {
            true => vec![usual.observation.dim()],
            false => self.controlled(usual).map(|each| each.observation.dim()).collect(),
        }
    }

    /// Whether all pedestrians that the campaign's controllers move see and choose the same, so that one policy can move each of them.
    pub fn is_uniform(&self, usual: &PedestrianRole) -> bool {
        let mut all = self.controlled(usual).map(|each| (&each.observation, &each.action));
        let first = all.next();
        all.all(|each| Some(each) == first)
    }

    /// What the pedestrians that the campaign's controllers move see and choose, if its pedestrian is this one.
    fn controlled<'a>(&'a self, usual: &'a PedestrianRole) -> impl Iterator<Item = &'a PedestrianRole> {
        let own = self.pedestrians.iter().filter(|each| each.controller == Controller::External);
        own.map(move |each| each.adversary.as_ref().unwrap_or(usual))
    }
}

/// Whether a signal of a group stands elsewhere than among the arguments of a function.
fn stands_alone(formula: &Formula, is_group: &impl Fn(usize) -> bool) -> bool {
    match formula {
        Formula::Constant(_) => false,
        Formula::Variable(id) => id.of_actor().is_some_and(|signal| is_group(signal.of) || is_group(signal.to)),
        Formula::Negate(inner) | Formula::Not(inner) => stands_alone(inner, is_group),
        Formula::Binary(_, left, right) => stands_alone(left, is_group) || stands_alone(right, is_group),
        Formula::Call(Function::Min | Function::Max, arguments) => {
            arguments.iter().any(|each| !matches!(each, Formula::Variable(_)) && stands_alone(each, is_group))
        }
        Formula::Call(_, arguments) => arguments.iter().any(|each| stands_alone(each, is_group)),
    }
}

/// A role with what places it, before its anchor has a number.
struct Written<'a> {
    declaration: &'a Declaration,
    /// The place of its name in the cast.
    span: Span,
    /// The key that places it, and the role that this key names; none for `ego` and for the spawn rule of the campaign.
    anchor: Option<(Span, Option<DeclarationId>)>,
    count: u32,
}

impl Lowering<'_> {
    /// The cast of a campaign; empty after reporting what is wrong with it.
    pub(crate) fn roles(&mut self, campaign: &Block, ids: Option<&[DeclarationId]>) -> Roles {
        self.understood(campaign, ids.unwrap_or_default()).unwrap_or_default()
    }

    fn understood(&mut self, campaign: &Block, ids: &[DeclarationId]) -> Option<Roles> {
        if ids.is_empty() {
            return None;
        }
        let before = self.said.len();
        let program = self.program;
        let places = campaign.members("cast");
        let span = |place: usize| places.get(place).copied().unwrap_or_else(|| campaign.place("cast"));
        let written: Vec<Written<'_>> =
            ids.iter().enumerate().map(|(place, id)| self.written(program.get(*id), span(place))).collect();
        let is_pedestrian = |each: &&Written<'_>| each.declaration.kind == PedestrianKeys::KIND;
        let free: Vec<&Written<'_>> =
            written.iter().filter(is_pedestrian).filter(|each| each.anchor.is_none()).collect();
        match free.as_slice() {
            [] => self.contradict(
                campaign.place("cast"),
                "the campaign's `spawn` places no pedestrian of this cast".into(),
                "leave one of them without `spawn`, `beside` and `ahead_of`",
            ),
            [first, ..] if first.count > 1 => self.contradict(
                first.span,
                format!(
                    "`{}` comes first and is a group, and the first pedestrian of a cast is one",
                    first.declaration.name
                ),
                "put another pedestrian before it",
            ),
            _ => {}
        }
        for each in &written {
            if let Some((place, Some(anchor))) = each.anchor
                && !ids.contains(&anchor)
            {
                let message = format!("`{}` is not in the cast", program.get(anchor).name);
                self.contradict(place, message, "add it to the `cast` of the campaign");
            }
        }
        self.refuse_circles(&written);
        self.refuse_followers(&written);
        self.refuse_words(&written);
        let is_left = |each: &&Written<'_>| {
            is_pedestrian(each) && each.declaration.block.keys::<PedestrianKeys>().moved_by.is_none()
        };
        if !written.iter().any(|each| is_left(&each)) {
            let help = "leave one pedestrian without `moved_by`: trainings, `pedestrians` and searches move it";
            self.contradict(
                campaign.place("cast"),
                "the blocks of the campaign move no pedestrian of this cast".into(),
                help,
            );
        }
        if self.said.len() > before {
            return None;
        }
        self.numbered(ids, &written)
    }

    /// Reports signals of roles that the campaign does not have, and signals of a group without `min` or `max` around them.
    pub(crate) fn compare_signals(&mut self, campaign: &Declaration, roles: &Roles) {
        let program = self.program;
        let reached = reached(program, campaign.id).into_iter().map(|id| program.get(id));
        for each in reached.filter(|each| each.form == RequirementKeys::KIND) {
            let place = each.block.place("formula");
            let RequirementKeys { formula: requirement, .. } = each.block.keys();
            let mut missing: Option<DeclarationId> = None;
            let mut crowds = false;
            for part in &requirement.parts {
                part.margin.substituted(&mut |id| {
                    let signal = id.of_actor().into_iter().flat_map(|signal| [signal.of, signal.to]);
                    missing = missing.or(signal
                        .filter(|role| roles.actors(*role).is_none())
                        .map(|role| DeclarationId(role - 1))
                        .next());
                    vec![id]
                });
                crowds |= stands_alone(&part.margin, &|role| roles.actors(role).is_some_and(|actors| actors.len() > 1));
            }
            if let Some(missing) = missing {
                let message = format!(
                    "`{}` names the role `{}`, and the cast of `{}` does not have it",
                    each.name,
                    program.get(missing).name,
                    campaign.name
                );
                self.contradict(
                    place,
                    message,
                    "add the role to the `cast` of the campaign, or take another requirement",
                );
            } else if crowds {
                let message = format!("`{}` has a signal of a group, which has a value for each member", each.name);
                self.contradict(place, message, "write `min(crowd.gap)` or `max(crowd.gap)`");
            }
        }
    }

    fn contradict(&mut self, span: Span, message: String, help: &str) {
        self.said.push(diagnostics::contradiction(span, message).help(help));
    }

    /// Reads the keys that place a role.
    fn written<'a>(&mut self, declaration: &'a Declaration, span: Span) -> Written<'a> {
        let block = &declaration.block;
        let role = |value: &Value| if let Value::Reference(id) = value { Some(*id) } else { None };
        let (given, count): (Vec<(&str, Option<DeclarationId>)>, u32) = if declaration.kind == PedestrianKeys::KIND {
            let keys: PedestrianKeys = block.keys();
            let given = [
                keys.spawn.map(|_| ("spawn", None)),
                keys.beside.map(|value| ("beside", role(&value))),
                keys.ahead_of.map(|value| ("ahead_of", role(&value))),
            ];
            (given.into_iter().flatten().collect(), keys.count)
        } else {
            let keys: CarKeys = block.keys();
            if keys.behind.is_some() && keys.driver.is_none() {
                self.contradict(
                    block.place("behind"),
                    "a parked car does not follow another one".into(),
                    "give it a driver: `driver: idm`",
                );
            }
            let is_given = block.places.iter().any(|(key, _)| *key == "ahead_of") || keys.behind.is_none();
            let ahead = is_given.then(|| ("ahead_of", role(&keys.ahead_of)));
            let behind = keys.behind.map(|_| ("behind", None));
            (behind.into_iter().chain(ahead).collect(), 1)
        };
        if let [(first, _), (second, _), ..] = given.as_slice() {
            let message =
                format!("`{}` begins at one place, and both `{first}` and `{second}` give one", declaration.name);
            self.contradict(block.place(second), message, "remove one of them");
        }
        let anchor = given.first().map(|(key, role)| (block.place(key), *role));
        Written { declaration, span, anchor, count }
    }

    /// Reports roles that are placed relative to each other in a circle.
    fn refuse_circles(&mut self, written: &[Written<'_>]) {
        let of = |id: DeclarationId| written.iter().find(|each| each.declaration.id == id);
        for each in written {
            let mut path = vec![each.declaration.name.as_str()];
            let mut here = each;
            while let Some((_, Some(next))) = here.anchor
                && let Some(other) = of(next)
                && path.len() <= written.len()
            {
                path.push(&other.declaration.name);
                here = other;
                if other.declaration.id == each.declaration.id {
                    let message = format!("the places of the cast go in a circle: `{}`", path.join("` from `"));
                    let help = "place one of them by `spawn`, or relative to `ego`";
                    self.contradict(each.anchor.map_or(each.span, |(place, _)| place), message, help);
                    return;
                }
            }
        }
    }

    /// Reports a second car behind the ego, and roles whose place depends on such a car: it has none before the encounter starts.
    fn refuse_followers(&mut self, written: &[Written<'_>]) {
        let follows = |each: &&Written<'_>| {
            each.declaration.kind == CarKeys::KIND && each.declaration.block.keys::<CarKeys>().behind.is_some()
        };
        let followers: Vec<&Written<'_>> = written.iter().filter(follows).collect();
        for second in followers.iter().skip(1) {
            let message = format!("`{}` is a second car behind the ego", second.declaration.name);
            self.contradict(second.declaration.block.place("behind"), message, "take one of them");
        }
        for each in written {
            if let Some((span, Some(anchor))) = each.anchor
                && followers.iter().any(|follower| follower.declaration.id == anchor)
            {
                let message = format!(
                    "`{}` is placed by a car that gets its place when the episode starts",
                    each.declaration.name
                );
                self.contradict(span, message, "place it relative to `ego` or to another role");
            }
        }
    }

    /// Reports roles with the names of words.
    fn refuse_words(&mut self, written: &[Written<'_>]) {
        for each in written.iter().filter(|each| [EGO, STILL].contains(&each.declaration.name.as_str())) {
            let message = format!("`{}` is a word of casts and no name of a role", each.declaration.name);
            self.contradict(each.span, message, "give it another name");
        }
    }

    /// The roles with the numbers of their actors.
    fn numbered(&mut self, ids: &[DeclarationId], written: &[Written<'_>]) -> Option<Roles> {
        let is_pedestrian = |each: &&&Written<'_>| each.declaration.kind == PedestrianKeys::KIND;
        let (mut walking, driving): (Vec<&Written<'_>>, Vec<&Written<'_>>) =
            written.iter().partition(|each| is_pedestrian(&each));
        walking.sort_by_key(|each| each.anchor.is_some());
        let all: u32 = walking.iter().map(|each| each.count).sum();
        if all as usize > ActorId::MAX_COUNT || driving.len() >= ActorId::MAX_COUNT {
            let message = format!(
                "the cast has {all} pedestrians and {} cars, and at most {} of a kind can be simulated",
                driving.len(),
                ActorId::MAX_COUNT
            );
            self.contradict(written.first()?.span, message, "take fewer");
            return None;
        }
        let mut next = 0;
        let mut groups: Vec<(DeclarationId, Vec<ActorId>)> = Vec::new();
        let mut numbers: Vec<(DeclarationId, ActorId)> = Vec::new();
        for each in &walking {
            numbers.push((each.declaration.id, ActorId::Pedestrian(next as u8)));
            let members = next..next + each.count;
            groups.push((each.declaration.id, members.map(|number| ActorId::Pedestrian(number as u8)).collect()));
            next += each.count;
        }
        numbers.extend(driving.iter().zip(1..).map(|(each, number)| (each.declaration.id, ActorId::Vehicle(number))));
        let actor = |value: &Value| match value {
            Value::Reference(id) => numbers.iter().find(|(own, _)| own == id).map_or(ActorId::EGO, |(_, actor)| *actor),
            _ => ActorId::EGO,
        };
        let ahead = |value: &Value, distance: &Distribution, aside: &Distribution| Placement::Ahead {
            anchor: actor(value),
            distance: distance.clone(),
            aside: aside.clone(),
        };
        groups.extend(numbers[walking.len()..].iter().map(|(id, car)| (*id, vec![*car])));
        let mut roles = Roles { ids: ids.to_vec(), actors: groups, ..Roles::default() };
        for each in walking {
            let (block, name) = (&each.declaration.block, Arc::from(each.declaration.name.as_str()));
            let keys: PedestrianKeys = block.keys();
            let place = match (keys.spawn, &keys.beside, &keys.ahead_of) {
                (Some(id), ..) => Some(Placement::Sector(Arc::new(self.sector_rule(id, block.place("spawn"))?))),
                (_, Some(value), _) => {
                    Some(Placement::Beside { anchor: actor(value), distance: keys.distance.clone() })
                }
                (.., Some(value)) => Some(ahead(value, &keys.distance, &keys.aside)),
                _ => None,
            };
            let controller = match &keys.moved_by {
                None => Controller::External,
                Some(Value::Choice(STILL)) => Controller::Own(walker::Controller::new(STILL, || Box::new(Scripted))),
                Some(word) => Controller::Own(self.untrained(block, "moved_by", word, place.is_none())?.0),
            };
            let adversary = keys.body.map(|id| self.adversary(id).value);
            let member = Walking { name, adversary, controller, place };
            roles.pedestrians.extend(std::iter::repeat_n(member, each.count as usize));
        }
        for each in driving {
            let keys: CarKeys = each.declaration.block.keys();
            let place = match keys.behind {
                Some(Leader::Ego) => Placement::Behind { gap: keys.gap },
                None => ahead(&keys.ahead_of, &keys.distance, &keys.aside),
            };
            let driver = match keys.driver {
                Some(id) => Some(self.policy(id)?),
                None => None,
            };
            let model = keys.vehicle.map(|id| self.vehicle(id).value);
            roles.cars.push(Car { name: each.declaration.name.as_str().into(), model, driver, place });
        }
        Some(roles)
    }

    /// The spawn rule of a role, which must be a sector.
    fn sector_rule(&mut self, id: DeclarationId, span: Span) -> Option<SpawnRule> {
        let rule = self.spawn_rule(id)?;
        if rule.scripted().is_some() {
            self.contradict(
                span,
                format!("`{}` states a walk, and a role takes a place alone", rule.name),
                "take a `spawn` without a kind",
            );
            return None;
        }
        Some(rule)
    }
}
