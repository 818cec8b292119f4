use super::sensor_suites::{SUITES, Suite};
use base::signature::{Form, Keys, Signature};
use lang::hir::Block;
use world::av::sensors::{Seam, Sector, SensorKeys, SensorModel};

/// The form `sensors`.
pub fn form() -> Form {
    let kind = |Suite { name, doc, figures, .. }: &Suite| {
        let own = Signature { name, doc, ..SensorKeys::signature() };
        figures.iter().fold(own, |kind, (key, value, doc)| kind.usually(key, Some(*value), doc))
    };
    Form { kinds: SUITES.iter().map(kind).collect(), ..Form::plain(SensorKeys::signature()) }
}

pub fn lower(block: &Block) -> SensorModel {
    let mut sectors: Vec<Sector> = block.inside().map(|(_, sector)| sector).collect();
    let mut seams: Vec<Seam> = block.inside().map(|(_, seam)| seam).collect();
    if let Some(suite) = SUITES.iter().find(|suite| suite.name == block.word) {
        if sectors.is_empty() {
            sectors.extend_from_slice(suite.sectors);
        }
        if seams.is_empty() {
            seams.extend_from_slice(suite.seams);
        }
    }
    SensorModel { keys: block.keys(), sectors, seams }
}
