// Smoke test of a packed extension without the editor.
//
//     node vsix.js UNPACKED_EXTENSION PROGRAM
//
// The editor's own module is a stand-in of empty classes. The extension loads its language client from the package, and the package's protocol
// library talks to `PROGRAM lsp`: a document with a mistake gets a diagnostic, and a hover gets help.
const { spawn } = require("child_process");
const { createRequire } = require("module");
const Module = require("module");
const path = require("path");

const [folder, program] = process.argv.slice(2).map((each) => path.resolve(each));
const inside = createRequire(path.join(folder, "extension.js"));
const empty = () => new Proxy(class {}, { get: (target, key) => (key in target || typeof key === "symbol" ? target[key] : empty()) });
const load = Module._load;
Module._load = (name, ...rest) => (name === "vscode" ? empty() : load(name, ...rest));

const extension = inside("./extension.js");
if (typeof extension.activate !== "function" || typeof extension.deactivate !== "function") throw new Error("the extension has no entry points");
const { createProtocolConnection, StreamMessageReader, StreamMessageWriter } = inside("vscode-languageserver-protocol/node");

(async () => {
  const server = spawn(program, ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
  const limit = setTimeout(() => { console.error("the server does not answer"); process.exit(1); }, 30_000);
  const connection = createProtocolConnection(new StreamMessageReader(server.stdout), new StreamMessageWriter(server.stdin));
  const published = new Promise((done) => connection.onNotification("textDocument/publishDiagnostics", done));
  connection.listen();
  const { capabilities } = await connection.sendRequest("initialize", { processId: process.pid, rootUri: null, capabilities: {} });
  await connection.sendNotification("initialized", {});
  const uri = "file:///smoke.scn", text = "edition 1\nspawn near { distance: 7 s .. 40 m }\n";
  await connection.sendNotification("textDocument/didOpen", { textDocument: { uri, languageId: "falsify", version: 1, text } });
  const { diagnostics } = await published;
  const hover = await connection.sendRequest("textDocument/hover", { textDocument: { uri }, position: { line: 1, character: 14 } });
  await connection.sendRequest("shutdown");
  await connection.sendNotification("exit");
  clearTimeout(limit);
  const code = diagnostics[0]?.code;
  if (!capabilities.hoverProvider || code !== "wrong-unit" || !hover) throw new Error(JSON.stringify({ capabilities, diagnostics, hover }));
  console.log(`diagnostic ${code}, help on hover, ${Object.keys(capabilities).length} capabilities`);
  process.exit(0);
})().catch((error) => { console.error(error); process.exit(1); });
