//! What `falsify` alone prints.

/// The first steps.
pub const WELCOME: &str = "\
falsify finds collisions of a self-driving car with a pedestrian that a careful human avoids.

Usage: falsify <COMMAND>

First steps:
  falsify demo              run a search without any file (about ten seconds) and open its page
  falsify new my.scn        write a commented scenario; `falsify new --help` lists the templates
  falsify check my.scn      find mistakes in it
  falsify run my.scn        train, search, evaluate, and write reports/NAME/report.html
  falsify explain WORD      explain a message, a form, a kind or a key

All commands: falsify --help";
