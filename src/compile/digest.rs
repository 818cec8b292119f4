//! A digest of what the files say about a task: its results are reused as long as the digest stays the same.

use super::fingerprint::Fingerprint;
use super::lowering::Lowering;
use super::reached::requirements_in;
use base::signature::{DeclarationId, Formula, Value};
use episode::robustness;
use lang::hir::{Block, Declaration};

/// Optional keys that were added to the language later. Where they are left out they change no digest, so that tasks keep their names.
const ADDED: &[&str] =
    &["credit", "destination", "forces", "from", "hard_starts", "others", "parameters", "policies", "road"];

impl Lowering<'_> {
    /// The fingerprint of a task that depends on these declarations. Towns and policies among them have been lowered before, so
    /// the files they name are known. The empty fingerprint when none is wanted.
    pub fn fingerprint(&mut self, parts: &[DeclarationId]) -> Fingerprint {
        self.fingerprint_with(parts, "")
    }

    /// The fingerprint of a task that also depends on what a text says.
    pub fn fingerprint_with(&mut self, parts: &[DeclarationId], more: &str) -> Fingerprint {
        if !self.read.wanted() {
            return Fingerprint::default();
        }
        let mut digest = blake3::Hasher::new();
        digest.update(more.as_bytes());
        for part in parts {
            digest.update(&self.digest(*part));
        }
        Fingerprint(*digest.finalize().as_bytes())
    }

    /// The fingerprint of a training that depends on these declarations and on its own, whatever its number of steps. The empty
    /// fingerprint when none is wanted.
    pub fn lineage(&mut self, parts: &[DeclarationId], training: DeclarationId) -> Fingerprint {
        if !self.read.wanted() {
            return Fingerprint::default();
        }
        let mut digest = blake3::Hasher::new();
        for part in parts {
            digest.update(&self.digest(*part));
        }
        digest.update(&self.digest_without(training, Some("steps")));
        Fingerprint(*digest.finalize().as_bytes())
    }

    fn digest(&mut self, id: DeclarationId) -> [u8; 32] {
        if let Some(known) = self.digests.get(&id) {
            return *known;
        }
        // Declarations that name each other in a circle are reported elsewhere.
        self.digests.insert(id, [0; 32]);
        let digest = self.digest_without(id, None);
        self.digests.insert(id, digest);
        digest
    }

    /// The digest of a declaration without one of its keys.
    fn digest_without(&mut self, id: DeclarationId, left_out: Option<&str>) -> [u8; 32] {
        let declaration = self.program.get(id);
        let mut out = Vec::new();
        for word in [declaration.form, declaration.kind, &declaration.name] {
            text(&mut out, word);
        }
        if let Some(map) = self.maps.get(&declaration.name).filter(|_| declaration.form == "town") {
            out.extend_from_slice(&self.read.seen(map).unwrap_or_default());
        }
        self.block(&mut out, declaration, &declaration.block, left_out);
        // The contents of what a program is made of are part of the scenario.
        for (path, digest) in self.noted(declaration).iter().flat_map(|program| &program.files) {
            text(&mut out, path);
            text(&mut out, digest);
        }
        *blake3::hash(&out).as_bytes()
    }

    fn block(&mut self, out: &mut Vec<u8>, declaration: &Declaration, block: &Block, left_out: Option<&str>) {
        text(out, block.word);
        text(out, block.name.as_deref().unwrap_or_default());
        let is_new = |key: &str, value: &Value| ADDED.contains(&key) && *value == Value::Absent;
        let counts = |(key, value): &(&'static str, &Value)| left_out != Some(*key) && !is_new(key, value);
        for (key, value) in block.arguments.iter().filter(counts) {
            text(out, key);
            self.value(out, declaration, value);
        }
        for clause in &block.clauses {
            text(out, clause.event);
            text(out, clause.word.unwrap_or_default());
            if let Some(id) = clause.subject {
                out.extend_from_slice(&self.digest(id));
            }
            self.formula(out, &clause.formula);
        }
        for child in &block.children {
            out.push(b'{');
            self.block(out, declaration, child, None);
            out.push(b'}');
        }
    }

    /// A value in the words of `Debug`, which tell all values apart; what it names by its digest or its contents.
    fn value(&mut self, out: &mut Vec<u8>, declaration: &Declaration, value: &Value) {
        match value {
            Value::Reference(id) => out.extend_from_slice(&self.digest(*id)),
            Value::List(members) => {
                text(out, &members.len().to_string());
                members.iter().for_each(|member| self.value(out, declaration, member));
            }
            Value::Formula(formula) => self.formula(out, formula),
            Value::Text(words) => {
                text(out, words);
                // If it names a file, its contents.
                out.extend_from_slice(&self.read.seen(&self.beside(declaration, words)).unwrap_or_default());
            }
            other => text(out, &format!("{other:?}")),
        }
    }

    fn formula(&mut self, out: &mut Vec<u8>, whole: &Formula) {
        let mut words = format!("{whole:?}");
        let mut named = Vec::new();
        requirements_in(whole, &mut named);
        for id in named {
            let digest = format!("{:?}", self.digest(id));
            words = words.replace(&format!("{:?}", robustness(id.0)), &digest);
        }
        text(out, &words);
    }
}

fn text(out: &mut Vec<u8>, text: &str) {
    out.extend_from_slice(&(text.len() as u64).to_le_bytes());
    out.extend_from_slice(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{Catalog, Fingerprint, compile};
    use base::diagnostic::Sources;

    /// The fingerprints of the evaluations in both towns, with this map and these changes of the text.
    fn fingerprints(map: &str, changes: &[(&str, &str)]) -> Vec<Fingerprint> {
        let text = r#"edition 1
town old = opendrive(file: "old.xodr")
town new { street quay { through: [(0 m, 0 m), (300 m, 0 m)] } }
driver mild = cruise(limit_share: 0.5)
spawn near { distance: 7 m .. 9 m }
episode short { ticks: 100 }
reward hits { on touch => 1 }
training quick = ppo(steps: 100)
campaign both {
  vehicle: model3 body: suicidal spawn: near episode: short training: quick
  train { towns: [new] drivers: [mild] rewards: [hits] runs: 1 }
  evaluate { towns: [old, new] drivers: [mild] pedestrians: [random] }
}
"#;
        let text = changes.iter().fold(text.to_string(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        let lib =
            |name: &str| std::fs::read_to_string(format!("{}/../../scenarios/lib/{name}", env!("CARGO_MANIFEST_DIR")));
        let read = |path: &Path| match path.to_str().unwrap() {
            "a.scn" => Ok(text.replacen("edition 1", "edition 1\nimport \"paper.scn\"\nimport \"drivers.scn\"", 1)),
            "old.xodr" => Ok(map.to_string()),
            other => lib(other),
        };
        let compiled = compile(&["a.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
        let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
        let campaign = &plan.campaigns[0];
        campaign.jobs.iter().map(|job| job.origin().fingerprint).collect()
    }

    #[test]
    fn a_recipe_follows_what_its_cell_hangs_on_and_nothing_else() {
        let map = include_str!("../../tests/suite/files/odd.xodr");
        let base = fingerprints(map, &[]);
        let changed = |map: &str, changes: &[(&str, &str)]| -> Vec<bool> {
            fingerprints(map, changes).iter().zip(&base).map(|(a, b)| a != b).collect()
        };
        // Training, old, new, and the prices in both, which are in the settings of these jobs.
        assert_eq!(changed(&format!("{map}<!-- resurveyed -->"), &[]), [false, true, false, true, false], "a map");
        assert_eq!(changed(map, &[("300 m", "301 m")]), [true, false, true, false, true], "a town");
        assert_eq!(changed(map, &[("steps: 100", "steps: 200")]), [true, false, false, false, false], "a training");
        assert_eq!(
            changed(map, &[("share: 0.5", "share:  0.50"), ("reward hits", "/// Pays.\nreward hits")]),
            [false; 5],
            "layout, help"
        );
        assert_eq!(changed(map, &[("share: 0.5", "share: 0.6")]), [true; 5], "a driver");
        assert_eq!(changed(map, &[("on touch => 1", "on touch => 1 + 0")]), [true; 5], "a formula");
        assert_eq!(
            changed(map, &[("reward hits", "reward more { on touch => 2 }\nreward hits")]),
            [false; 5],
            "something else"
        );
    }
}
