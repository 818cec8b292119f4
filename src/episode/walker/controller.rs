use std::fmt;
use std::sync::Arc;

use super::WalkPolicy;

/// A controller that learns nothing: its name, and how a walk policy is made of it. Two are equal if their names are.
#[derive(Clone)]
pub struct Controller {
    name: Arc<str>,
    make: Arc<dyn Fn() -> Box<dyn WalkPolicy> + Send + Sync>,
}

impl Controller {
    /// A controller with this name.
    pub fn new(name: &str, make: impl Fn() -> Box<dyn WalkPolicy> + Send + Sync + 'static) -> Self {
        Self { name: name.into(), make: Arc::new(make) }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn walk_policy(&self) -> Box<dyn WalkPolicy> {
        (self.make)()
    }
}

impl fmt::Debug for Controller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Controller").field(&self.name).finish()
    }
}

impl PartialEq for Controller {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Controller {}

impl std::hash::Hash for Controller {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

impl PartialOrd for Controller {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Controller {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.name.cmp(&other.name)
    }
}
