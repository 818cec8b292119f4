use base::signature::{Form, Keys};
use lang::hir::Declaration;
use world::likelihood::{
    Estimator, Importance, ImportanceKeys, MonteCarlo, MonteCarloKeys, SubsetSimulation, SubsetSimulationKeys,
};

/// The form `estimator`.
pub fn form() -> Form {
    let doc = "A method that estimates how likely failures are; an `estimate` block of a campaign uses it.";
    let kinds = vec![MonteCarloKeys::signature(), SubsetSimulationKeys::signature(), ImportanceKeys::signature()];
    Form::of_kinds("estimator", doc, kinds)
}

/// The estimator.
pub fn lower(declaration: &Declaration) -> Estimator {
    let block = &declaration.block;
    match declaration.kind {
        SubsetSimulationKeys::KIND => Estimator::SubsetSimulation(SubsetSimulation::from_keys(block.keys())),
        ImportanceKeys::KIND => Estimator::Importance(Importance::from_keys(block.keys())),
        _ => Estimator::MonteCarlo(MonteCarlo::from_keys(block.keys())),
    }
}
