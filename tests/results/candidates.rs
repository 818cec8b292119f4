//! Several trainings of which the best one on validation starts is kept.

use std::path::Path;

use base::seed::Seed;
use compile::{Campaign, Catalog, Training, compile};
use results::campaign::{self, NoStore, Silent};
use results::jobs::TrainingResult;

fn campaign(candidates: u32) -> Campaign {
    let text = format!(
        "edition 1
         import \"lib/paper.scn\"
         import \"lib/drivers.scn\"
         import \"lib/towns.scn\"
         training two = ppo(environments: 2, steps_per_update: 64, steps: 128)
         campaign several {{
           vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: two
           train {{ towns: [harbour] drivers: [blind] rewards: [r1] runs: 1  candidates: {candidates} }}
         }}"
    );
    let root = crate::repository().join("scenarios/candidates.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.unwrap().campaigns.remove(0)
}

fn trained(campaign: &Campaign, threads: usize) -> TrainingResult {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let finished = pool.install(|| campaign::run(campaign, &Seed::root(3), &NoStore, &Silent));
    assert!(finished.is_whole);
    let [training] = finished.all::<TrainingResult>() else { panic!("it is one training") };
    training.clone()
}

fn networks(training: &TrainingResult) -> Vec<u8> {
    training.result.as_ref().unwrap().to_safetensors()
}

#[test]
fn the_candidate_that_earns_most_on_validation_starts_is_kept_at_any_number_of_threads() {
    let plan = campaign(4);
    let kept = trained(&plan, 2);
    assert_eq!((kept.validation.len(), kept.decisions), (4, 4 * 128));
    assert!(kept.validation.iter().all(|reward| *reward <= kept.validation[kept.kept()]), "{:?}", kept.validation);
    assert!(kept.validation.windows(2).any(|pair| pair[0] != pair[1]), "candidates have different seeds");
    let alone = trained(&plan, 1);
    assert_eq!((networks(&alone), &alone.validation), (networks(&kept), &kept.validation));

    let single = trained(&campaign(1), 2);
    assert!(single.validation.is_empty());
    let first: &Training = plan.nth(0);
    let seed = Seed::root(3);
    assert_eq!(first.candidate_seed(0, &seed), first.key.seed(&seed), "one training is the first candidate");
    assert_eq!(networks(&single) == networks(&kept), kept.kept() == 0);
}
