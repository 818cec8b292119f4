//! The meaning of the language's own words: those that are not a form, kind or key.

/// A word that every file may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Word {
    /// The word.
    pub name: &'static str,
    /// What it means.
    pub text: &'static str,
    /// A file that uses it.
    pub example: &'static str,
}

/// The words, in the order in which a reader meets them.
pub const WORDS: &[Word] = &[
    Word {
        name: "edition",
        text: "The edition of the language that a file is written in; it stands first in every file. There is one.",
        example: "edition 1\n",
    },
    Word {
        name: "import",
        text: "Takes over the declarations and parameters of another file, or those that are named. The path is relative to the folder of this file; `std/…` leads to the library inside the program unless there is such a file.",
        example: "edition 1\nimport \"std/paper.scn\"\nimport harbour, village from \"std/towns.scn\"\n",
    },
    Word {
        name: "param",
        text: "A value with a name and a type, used by name wherever a value may stand. `--set name=value` and a `matrix` give it another. Types are the dimensions (`length`, `speed`, …), `number`, `integer`, `boolean`, `text`, `word`, and the forms.",
        example: "edition 1\nparam far: length = 30 m\nspawn near { distance: far / 4 .. far }\n",
    },
    Word {
        name: "matrix",
        text: "A block of a campaign: the campaign is run once for every combination of values of parameters. A parameter that is set on the command line keeps that one value.",
        example: "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\nparam far: length = 30 m\nspawn here { distance: 7 m .. far }\ncampaign distances {\n  vehicle: model3  body: suicidal  spawn: here  episode: thirty_seconds  training: ppo_paper\n  matrix { far: [20 m, 30 m] }\n  train { towns: [harbour]  drivers: [behavior]  rewards: [r1]  runs: 1 }\n}\n",
    },
    Word {
        name: "set",
        text: "No word of files: `--set NAME=VALUE` on the command line gives a parameter, or a key of a declaration, another value for one run. For several values, one run after another, write a `matrix` block; a parameter that is set keeps the one value.",
        example: "edition 1\n// falsify run --set 'far=20 m' --set 'near.distance=9 m' my.scn\nparam far: length = 30 m\nspawn near { distance: 7 m .. far }\n",
    },
    Word {
        name: "on",
        text: "A clause of a reward: what an event is worth, as a formula of a plain number. `falsify explain events` lists the events and what formulas may name at each.",
        example: "edition 1\nreward r {\n  on touch(front) => max(3, 1.5 * v_c in m/s)\n  on touch => 1\n}\n",
    },
    Word {
        name: "in",
        text: "Makes the plain number of a quantity, counted in a unit. Formulas of rewards are plain numbers, so speeds and lengths are counted on purpose.",
        example: "edition 1\nreward r { on touch => v_c in km/h / 10 }\n",
    },
    Word {
        name: "uniform",
        text: "A distribution: all values between two ends are as likely. `low .. high` is the same.",
        example: "edition 1\nspawn s { distance: uniform(7 m, 30 m) }\n",
    },
    Word {
        name: "normal",
        text: "A distribution: a mean and a standard deviation. It has no ends, so where a key has bounds it must be `truncated`.",
        example: "edition 1\nspawn s { ego_speed: truncated(normal(8 m/s, 2 m/s), 2 m/s .. 13 m/s) }\n",
    },
    Word {
        name: "truncated",
        text: "A distribution without what lies outside of a range, as if what falls there were drawn again.",
        example: "edition 1\nspawn s { distance: truncated(normal(15 m, 5 m), 7 m .. 30 m) }\n",
    },
    Word {
        name: "choice",
        text: "One of several values, ranges or distributions, each as likely.",
        example: "edition 1\nspawn s { bearing: choice(-60 deg .. -30 deg, 30 deg .. 60 deg) }\n",
    },
    Word {
        name: "weighted",
        text: "One of several values, ranges or distributions, each with a weight: likely in proportion to it.",
        example: "edition 1\nspawn s { distance: weighted((3, 7 m .. 15 m), (1, 15 m .. 30 m)) }\n",
    },
];
