//! Starts `falsify lsp` for scenarios in Zed.

use zed_extension_api::{self as zed, Command, LanguageServerId, Worktree};

struct Falsify;

impl zed::Extension for Falsify {
    fn new() -> Self {
        Self
    }

    fn language_server_command(&mut self, _: &LanguageServerId, worktree: &Worktree) -> zed::Result<Command> {
        let command = worktree
            .which("falsify")
            .ok_or("there is no `falsify` on the search path: install it, and open the folder again")?;
        Ok(Command { command, args: vec!["lsp".into()], env: worktree.shell_env() })
    }
}

zed::register_extension!(Falsify);
