// Commands of the server: `workspace/executeCommand`, what they answer and show.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import * as path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { CancellationTokenSource, LSPErrorCodes } from "vscode-languageserver-protocol";
import { Session, folder, uri, usual, within } from "./client";

// A function that loses its digits where a and b are close.
const shader = `#version 450
layout(std140, binding = 0) uniform Block { vec3 a; float b; vec4 c; } u;
layout(location = 0) out vec4 colour;
float apart(float a, float b) { return (a - b) / a; }
void main() { colour = vec4(u.a, apart(u.b, u.c.x)); }
`;

interface Output {
  readonly code: number;
  readonly text: string;
  readonly messages: string;
}

async function started(): Promise<{
  session: Session;
  file: string;
  run: (name: string, ...given: unknown[]) => Promise<Output>;
}> {
  const place = folder({ "a.frag": shader });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const run = (name: string, ...given: unknown[]) => {
    return session.request<Output>("workspace/executeCommand", { command: `landfall.${name}`, arguments: given });
  };
  return { session, file, run };
}

function shown(session: Session): { uri: string; external?: boolean }[] {
  const requests = session.asked.filter((one) => one.method === "window/showDocument");
  return requests.map((one) => one.params as { uri: string; external?: boolean });
}

test("a block is copied as Rust and as C, as it is edited", async () => {
  const { session, file, run } = await started();
  await session.replace(file, "vec4 c;", "vec4 d;");
  const rust = await run("emit", uri(file), "Block", "rust");
  assert.equal(rust.code, 0);
  assert.match(rust.text, /pub struct Block\b[^]*\ba: [^]*\bb: f32[^]*\bd: /);
  assert.doesNotMatch(rust.text, /\bc: /);
  const c = await run("emit", uri(file), "Block", "c");
  assert.match(c.text, /float b;/);
  await assert.rejects(run("emit", uri(file), "Block"));
  await assert.rejects(run("emit", uri(file), "Nothing", "rust"));
  await session.end();
});

test("the memory map is a page that is shown outside, at the block, as it is edited", async () => {
  const { session, file, run } = await started();
  await session.replace(file, "vec4 c;", "vec4 unsaved;");
  await run("memoryMap", uri(file), "Block");
  const [page] = await session.until("a page", () => (shown(session).length > 0 ? shown(session) : undefined));
  assert(page !== undefined);
  assert.equal(page.external, true);
  const text = readFileSync(fileURLToPath(page.uri), "utf8");
  assert.match(text, /^<!DOCTYPE html>/i);
  const data = JSON.parse(/id="data">([^]*?)<\/script>/.exec(text)?.[1] ?? "") as { at: string; shaders: unknown };
  assert.equal(data.at, "Block");
  assert.match(JSON.stringify(data.shaders), /"name":"unsaved"/);
  await session.end();
});

test("a lint is explained", async () => {
  const { session, run } = await started();
  const { text } = await run("rule", "vec3-array");
  assert.match(text, /vec3-array/);
  await assert.rejects(run("rule", "no-such-lint"));
  await assert.rejects(run("rule"));
  await session.end();
});

test("a function is stressed", async () => {
  const { session, file, run } = await started();
  const { text } = await run("stress", uri(file), "apart");
  assert.match(text, /apart/);
  await session.end();
});

test("a block is verified with progress between `begin` and `end`", async () => {
  const { session, file, run } = await started();
  const { code, text } = await run("verify", uri(file), "Block");
  assert.equal(code, 0, text);
  assert.match(text, /Block/);
  const created = session.asked.filter((one) => one.method === "window/workDoneProgress/create");
  const tokens = created.map((one) => (one.params as { token: string }).token);
  assert.equal(tokens.length, 1);
  const reports = session.asked.filter((one) => one.method === "$/progress");
  const values = reports.map((one) => one.params as { token: string; value: { kind: string; title?: string } });
  assert.deepEqual(
    values.map((one) => one.token),
    [tokens[0], tokens[0]],
  );
  assert.deepEqual(
    values.map((one) => one.value.kind),
    ["begin", "end"],
  );
  await session.end();
});

test("a command ends when its request is cancelled", async () => {
  const { session, file } = await started();
  const source = new CancellationTokenSource();
  const params = { command: "landfall.verify", arguments: [uri(file), "Block"] };
  const runs = session.connection.sendRequest("workspace/executeCommand", params, source.token);
  await session.until("progress", () => session.asked.some((one) => one.method === "$/progress"));
  source.cancel();
  const error = await within(
    runs.then(
      () => assert.fail("it ran to its end"),
      (cause: { code: number }) => cause,
    ),
    "an answer",
  );
  assert.equal(error.code, LSPErrorCodes.RequestCancelled);
  // The server goes on.
  assert((await session.labels(file, "Block")).length > 0);
  await session.end();
});

test("a command ends when its progress is cancelled", async () => {
  const { session, file } = await started();
  const params = { command: "landfall.verify", arguments: [uri(file), "Block"] };
  const runs = session.connection.sendRequest("workspace/executeCommand", params);
  const begun = await session.until("progress", () => session.asked.find((one) => one.method === "$/progress"));
  const { token } = begun.params as { token: string };
  await session.notify("window/workDoneProgress/cancel", { token });
  const error = await within(
    runs.then(
      () => assert.fail("it ran to its end"),
      (cause: { code: number }) => cause,
    ),
    "an answer",
  );
  assert.equal(error.code, LSPErrorCodes.RequestCancelled);
  await session.end();
});

test("a command reports under the token that the client gives", async () => {
  const { session } = await started();
  const params = { command: "landfall.rule", arguments: ["vec3-array"], workDoneToken: "mine" };
  await session.request("workspace/executeCommand", params);
  const reports = session.asked.filter((one) => one.method === "$/progress");
  assert.deepEqual(
    reports.map((one) => (one.params as { token: string }).token),
    ["mine", "mine"],
  );
  assert(!session.asked.some((one) => one.method === "window/workDoneProgress/create"));
  await session.end();
});

test("a client that shows no documents and no progress is asked for neither", async () => {
  const place = folder({ "a.frag": shader });
  const { window: _, ...capabilities } = usual;
  const session = await Session.start([place], { capabilities });
  await session.request("workspace/executeCommand", { command: "landfall.rule", arguments: ["vec3-array"] });
  for (const method of ["window/showDocument", "window/workDoneProgress/create", "$/progress"]) {
    assert(!session.asked.some((one) => one.method === method), method);
  }
  await session.end();
});
