// Starts `falsify lsp` and connects it with the editor. All features come from the server.
const { workspace, window } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = async function activate() {
  const command = workspace.getConfiguration("falsify").get("path", "falsify");
  client = new LanguageClient(
    "falsify",
    "falsify",
    { command, args: ["lsp"] },
    { documentSelector: [{ language: "falsify" }] },
  );
  try {
    await client.start();
  } catch (error) {
    window.showErrorMessage(`falsify: cannot start \`${command} lsp\`: ${error.message}. Set "falsify.path".`);
  }
};

exports.deactivate = () => client?.stop();
