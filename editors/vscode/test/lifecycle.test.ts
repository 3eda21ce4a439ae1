// From `initialize` to `exit`, and messages that are wrong: sections "Base Protocol", "Lifecycle Messages"
// and "Cancellation Support" of the specification, 3.17.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import * as path from "node:path";
import { test } from "node:test";
import {
  CancellationTokenSource,
  ErrorCodes,
  type InitializeResult,
  LSPErrorCodes,
} from "vscode-languageserver-protocol";
import { Session, folder, program, uri, usual, withCode, within } from "./client";

const shader = "#version 450\nlayout(std140, binding = 0) uniform B { vec4 a; vec4 b; } u;\n";

test("the capabilities name what the protocol has for it", async () => {
  const session = new Session();
  const { capabilities, serverInfo }: InitializeResult = await session.initialize([folder({ "a.frag": shader })]);
  assert.equal(serverInfo?.name, "landfall");
  assert.equal(capabilities.positionEncoding, "utf-16");
  const sync = capabilities.textDocumentSync;
  assert(typeof sync === "object" && sync.openClose === true && sync.change === 2, "incremental edits");
  for (const name of [
    "inlayHintProvider",
    "hoverProvider",
    "definitionProvider",
    "declarationProvider",
    "implementationProvider",
    "referencesProvider",
    "documentSymbolProvider",
    "workspaceSymbolProvider",
    "codeActionProvider",
  ] as const) {
    assert(capabilities[name], name);
  }
  assert(typeof capabilities.renameProvider === "object" && capabilities.renameProvider.prepareProvider);
  assert.equal(capabilities.workspace?.workspaceFolders?.supported, true);
  assert((capabilities.executeCommandProvider?.commands.length ?? 0) > 0);
  await session.end();
});

test("before `initialize` all requests but it are refused", async () => {
  const session = new Session();
  const early = session.request("textDocument/hover", {
    textDocument: { uri: "file:///a.frag" },
    position: { line: 0, character: 0 },
  });
  await assert.rejects(early, withCode(ErrorCodes.ServerNotInitialized));
  await session.initialize([folder({})]);
  await assert.rejects(session.initialize([]), withCode(ErrorCodes.InvalidRequest));
  await session.end();
});

test("after `shutdown` requests are refused, and `exit` exits with 0", async () => {
  const session = await Session.start([folder({})]);
  assert.equal(await session.request("shutdown"), null);
  await assert.rejects(session.request("shutdown"), withCode(ErrorCodes.InvalidRequest));
  await session.notify("exit");
  assert.equal(await within(session.exited, "exit"), 0);
});

test("`exit` without `shutdown` exits with 1", async () => {
  const session = await Session.start([folder({})]);
  await session.notify("exit");
  assert.equal(await within(session.exited, "exit"), 1);
});

test("`exit` before `initialize` ends the server", async () => {
  const session = new Session();
  await session.notify("exit");
  assert.equal(await within(session.exited, "exit"), 1);
});

test("a client that is gone takes the server with it", async () => {
  const session = await Session.start([folder({ "a.frag": shader })]);
  session.process.stdin?.end();
  await within(session.exited, "the end of the server");
});

test("methods and parameters that are not those of the protocol are refused", async () => {
  const session = await Session.start([folder({})]);
  await assert.rejects(session.request("textDocument/nothing", {}), withCode(ErrorCodes.MethodNotFound));
  await assert.rejects(session.request("$/nothing", {}), withCode(ErrorCodes.MethodNotFound));
  await assert.rejects(session.request("textDocument/hover", { position: 1 }), withCode(ErrorCodes.InvalidParams));
  await assert.rejects(
    session.request("workspace/executeCommand", { command: "landfall.nothing" }),
    withCode(ErrorCodes.InvalidParams),
  );
  await session.notify("$/nothing", {});
  await session.notify("textDocument/didChange", { textDocument: 1 });
  await session.notify("textDocument/didOpen", null);
  await session.end();
});

test("a message that is no JSON is answered with an error, and the next as if it had not been", async () => {
  const child = spawn(program, ["lsp"], { stdio: "pipe" });
  let output = "";
  child.stdout.on("data", (text: Buffer) => (output += text.toString()));
  const exited = new Promise<number | null>((resolve) => child.once("exit", resolve));
  const send = (body: string, header = "") => {
    child.stdin.write(`${header}Content-Length: ${Buffer.byteLength(body)}\r\n\r\n${body}`);
  };
  send("{ no JSON");
  send('{"jsonrpc":"2.0"}');
  send("[1, 2]");
  const capabilities = { jsonrpc: "2.0", id: "first", method: "initialize", params: { capabilities: {} } };
  send(JSON.stringify(capabilities), "Content-Type: application/vscode-jsonrpc; charset=utf-8\r\n");
  send('{"jsonrpc":"2.0","id":"last","method":"shutdown"}');
  send('{"jsonrpc":"2.0","method":"exit"}');
  assert.equal(await within(exited, "exit"), 0);
  const bodies = output.split(/Content-Length: \d+\r\n\r\n/).filter((body) => body !== "");
  const answers = bodies.map((body) => JSON.parse(body) as { id: unknown; error?: { code: number }; result?: unknown });
  const [noJson] = answers;
  assert.equal(noJson?.error?.code, ErrorCodes.ParseError);
  // JSON-RPC 2.0, section 5: null where the number of the request is not known.
  assert.equal(noJson.id, null);
  assert(answers.some((one) => one.id === "first" && one.result !== undefined));
  assert(answers.some((one) => one.id === "last" && one.result === null));
});

test("a request that waits is cancelled", async () => {
  const place = folder({ "a.frag": shader });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const source = new CancellationTokenSource();
  const params = { textDocument: { uri: uri(file) }, query: "" };
  const waits = session.connection.sendRequest("textDocument/documentSymbol", params, source.token);
  source.cancel();
  // It may have been answered before.
  const outcome = await within(
    waits.then(
      () => "answered",
      (cause: { code: number }) => cause.code,
    ),
    "an answer",
  );
  assert(["answered", LSPErrorCodes.RequestCancelled].includes(outcome), String(outcome));
  // One that was not asked is nobody's.
  await session.notify("$/cancelRequest", { id: 123_456 });
  await session.notify("$/cancelRequest", { id: "unknown" });
  await session.notify("$/cancelRequest", {});
  await session.end();
});

test("requests that wait when they are cancelled are answered so, each once", async () => {
  const child = spawn(program, ["lsp"], { stdio: "pipe" });
  let output = "";
  child.stdout.on("data", (text: Buffer) => (output += text.toString()));
  const exited = new Promise<number | null>((resolve) => child.once("exit", resolve));
  const framed = (message: object) => {
    const body = JSON.stringify({ jsonrpc: "2.0", ...message });
    return `Content-Length: ${Buffer.byteLength(body)}\r\n\r\n${body}`;
  };
  // One that takes its time, before those that wait.
  const members = Array.from({ length: 20_000 }, (_, at) => `float m${at};`).join("\n");
  const text = `#version 450\nlayout(std430, binding = 0) buffer B {\n${members}\n};\nvoid main() {}\n`;
  const textDocument = { uri: uri(path.join(folder({}), "long.frag")), languageId: "glsl", version: 1, text };
  const symbols = (id: number) => ({ id, method: "workspace/symbol", params: { query: "" } });
  const waiting = Array.from({ length: 50 }, (_, at) => 100 + at);
  const messages = [
    { id: 1, method: "initialize", params: { capabilities: {} } },
    { method: "initialized", params: {} },
    { method: "textDocument/didOpen", params: { textDocument } },
    { id: 2, method: "textDocument/documentSymbol", params: { textDocument } },
    ...waiting.map(symbols),
    ...waiting.map((id) => ({ method: "$/cancelRequest", params: { id } })),
    { id: 3, method: "shutdown" },
    { method: "exit" },
  ];
  child.stdin.write(messages.map(framed).join(""));
  assert.equal(await within(exited, "exit"), 0);
  const answers = output.split(/Content-Length: \d+\r\n\r\n/).filter((body) => body !== "");
  const read = answers.map((body) => JSON.parse(body) as { id?: unknown; error?: { code: number } });
  for (const id of waiting) {
    const own = read.filter((one) => one.id === id);
    assert.deepEqual(
      own.map((one) => one.error?.code),
      [LSPErrorCodes.RequestCancelled],
      `${id}`,
    );
  }
});

test("a client that answers no request of the server gets its own answered", async () => {
  const place = folder({ "a.frag": shader });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place], { answers: false });
  await session.open(file);
  assert.deepEqual(await session.labels(file, "vec4 a"), ["32 bytes, std140", "@0", "@16"]);
  await session.replace(file, "vec4 b", "float b");
  assert.deepEqual(await session.labels(file, "vec4 a"), [
    "32 bytes, 12 of them padding, std140",
    "@0",
    "@16, +12 padding",
  ]);
  await session.end();
});

test("settings that are null are those that are not set", async () => {
  const place = folder({ "a.frag": shader });
  const file = path.join(place, "a.frag");
  const names = ["inlayHints", "targets", "defines", "features", "rulePages"];
  const settings = Object.fromEntries(names.map((name) => [name, null]));
  const session = await Session.start([place], { settings, initializationOptions: settings });
  await session.open(file);
  assert.deepEqual(await session.labels(file, "vec4 a"), ["32 bytes, std140", "@0", "@16"]);
  assert(!session.asked.some((one) => one.method === "window/showMessage"));
  await session.end();
});

test("settings are asked for where the client answers, else taken as they are sent", async () => {
  const place = folder({ "a.frag": shader });
  const file = path.join(place, "a.frag");
  const noOffsets = { inlayHints: { offsets: false } };
  const asked = await Session.start([place], { settings: noOffsets });
  await asked.open(file);
  await asked.until("the settings asked for", () =>
    asked.asked.some((one) => one.method === "workspace/configuration"),
  );
  await asked.request("workspace/symbol", { query: "" });
  assert.deepEqual(await asked.labels(file, "vec4 a"), ["32 bytes, std140"]);
  await asked.end();

  const { configuration: _, ...workspace } = usual.workspace ?? {};
  const sent = await Session.start([place], {
    capabilities: { ...usual, workspace },
    initializationOptions: { inlayHints: { blocks: false } },
  });
  await sent.open(file);
  assert.deepEqual(await sent.labels(file, "vec4 a"), ["@0", "@16"]);
  await sent.followed("workspace/inlayHint/refresh", () => {
    return sent.notify("workspace/didChangeConfiguration", { settings: { landfall: noOffsets } });
  });
  assert.deepEqual(await sent.labels(file, "vec4 a"), ["32 bytes, std140"]);
  await sent.followed("window/showMessage", () => {
    return sent.notify("workspace/didChangeConfiguration", { settings: { landfall: { targets: ["nothing"] } } });
  });
  assert.deepEqual(await sent.labels(file, "vec4 a"), ["32 bytes, std140"], "the last good settings hold");
  await sent.end();
});
