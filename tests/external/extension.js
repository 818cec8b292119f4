// Starts the extension of VS Code without the editor: the modules of the editor are stand-ins that print what they are asked for.
const Module = require("module");
const load = Module._load;
class LanguageClient {
  constructor(id, name, server, client) {
    console.log(JSON.stringify({ id, server, client }));
  }
  async start() {
    throw new Error("no such program");
  }
  async stop() {}
}
const vscode = {
  workspace: { getConfiguration: () => ({ get: (key, value) => value }) },
  window: { showErrorMessage: (message) => console.log(message) },
};
Module._load = (name, ...rest) =>
  name === "vscode" ? vscode : name === "vscode-languageclient/node" ? { LanguageClient } : load(name, ...rest);
require(process.argv[2]).activate();
