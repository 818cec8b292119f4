use world::sim::WalkCommand;

/// A command that is kept for some decisions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    pub command: WalkCommand,
    /// The number of decisions.
    pub decisions: usize,
}

/// The commands of an episode as segments of equal ones, for each pedestrian.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub pedestrians: Vec<Vec<Segment>>,
}

impl Plan {
    /// Of commands, one for each of these pedestrians in every decision.
    pub fn new(commands: &[WalkCommand], pedestrians: usize) -> Self {
        let mut plan = Self { pedestrians: vec![Vec::<Segment>::new(); pedestrians] };
        for decision in commands.chunks_exact(pedestrians) {
            for (segments, command) in plan.pedestrians.iter_mut().zip(decision) {
                match segments.last_mut().filter(|last| last.command == *command) {
                    Some(last) => last.decisions += 1,
                    None => segments.push(Segment { command: *command, decisions: 1 }),
                }
            }
        }
        plan
    }

    /// One command for each pedestrian in every decision; a pedestrian with fewer decisions keeps its last command.
    pub fn commands(&self) -> Vec<WalkCommand> {
        let length = |segments: &Vec<Segment>| segments.iter().map(|segment| segment.decisions).sum::<usize>();
        let longest = self.pedestrians.iter().map(length).max().unwrap_or(0);
        let walk = |segments: &Vec<Segment>| {
            let each = segments.iter().flat_map(|segment| std::iter::repeat_n(segment.command, segment.decisions));
            let last = segments.last().map_or_else(WalkCommand::default, |last| last.command);
            each.chain(std::iter::repeat(last)).take(longest).collect::<Vec<_>>()
        };
        let walks: Vec<Vec<WalkCommand>> = self.pedestrians.iter().map(walk).collect();
        (0..longest).flat_map(|decision| walks.iter().map(move |walk| walk[decision])).collect()
    }

    /// The number of commands.
    pub fn count(&self) -> usize {
        self.pedestrians.iter().map(Vec::len).sum()
    }

    /// The plan without some consecutive segments of a pedestrian, whose time the neighbour before or after them takes; `None` if there is none.
    pub fn without(&self, pedestrian: usize, first: usize, count: usize, to_next: bool) -> Option<Self> {
        let mut plan = self.clone();
        let segments = &mut plan.pedestrians[pedestrian];
        let heir = if to_next { first + count } else { first.checked_sub(1)? };
        let decisions: usize = segments.get(first..first + count)?.iter().map(|segment| segment.decisions).sum();
        segments.get_mut(heir)?.decisions += decisions;
        segments.drain(first..first + count);
        Some(plan)
    }

    /// The plan in which a segment and the next one are one with their mean velocity; `None` if there is no next one.
    pub fn merged(&self, pedestrian: usize, first: usize) -> Option<Self> {
        let mut plan = self.clone();
        let segments = &mut plan.pedestrians[pedestrian];
        let [one, other] = *segments.get(first..first + 2)? else { return None };
        let (a, b) = (one.decisions as f64, other.decisions as f64);
        let mean = |part: fn(f64) -> f64| {
            let of = |segment: &Segment| segment.command.speed * part(segment.command.heading);
            (a * of(&one) + b * of(&other)) / (a + b)
        };
        let (x, y) = (mean(libm::cos), mean(libm::sin));
        let heading = if x == 0.0 && y == 0.0 { other.command.heading } else { libm::atan2(y, x) };
        let command = WalkCommand { heading, speed: libm::hypot(x, y) };
        segments[first] = Segment { command, decisions: one.decisions + other.decisions };
        segments.remove(first + 1);
        Some(plan)
    }

    /// The plan with another command in a segment.
    pub fn with(&self, pedestrian: usize, place: usize, command: WalkCommand) -> Self {
        let mut plan = self.clone();
        plan.pedestrians[pedestrian][place].command = command;
        plan
    }
}
