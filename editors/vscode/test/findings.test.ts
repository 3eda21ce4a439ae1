// Findings of documents as they are edited, with their fixes, the configuration and the locks.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, symlinkSync } from "node:fs";
import * as path from "node:path";
import { test } from "node:test";
import type { CodeAction } from "vscode-languageserver-protocol";
import { DiagnosticSeverity } from "vscode-languageserver-protocol";
import { Session, folder, program, uri, usual, write } from "./client";

// By std140 the second vec3 is at 16, since 12 is no multiple of 16; the comment says 12.
const wrongComment = `#version 450
layout(std140, binding = 0) uniform Block {
    vec3 a; // offset 0
    vec3 b; // offset 12
} u;
layout(location = 0) out vec4 colour;
void main() { colour = vec4(u.a + u.b, 1.0); }
`;

function only(actions: CodeAction[], title: RegExp): CodeAction {
  const found = actions.filter((one) => title.test(one.title));
  assert.equal(found.length, 1, `${title}: ${actions.map((one) => one.title).join(" | ")}`);
  return found[0] as CodeAction;
}

test("a finding has its place, code and source, and goes with what it is about", async () => {
  const place = folder({ "a.frag": wrongComment, "landfall.toml": "" });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const found = await session.finding(file, "stale-comment");
  assert.equal(found.source, "landfall");
  assert.equal(found.severity, DiagnosticSeverity.Warning);
  assert.equal(found.range.start.line, 3);
  assert.match(typeof found.message === "string" ? found.message : found.message.value, /16/);
  // None where it was found before the document was open.
  assert([undefined, 1].includes(session.findings.get(uri(file))?.version ?? undefined));
  await session.replace(file, "offset 12", "offset 16");
  await session.withoutFinding(file, "stale-comment");
  await session.replace(file, "offset 16", "offset 20");
  await session.finding(file, "stale-comment");
  assert.equal(session.findings.get(uri(file))?.version, 3);
  await session.end();
});

test("the code of a finding opens its page where the setting says so", async () => {
  const place = folder({ "a.frag": wrongComment });
  const file = path.join(place, "a.frag");
  const settings = { rulePages: "https://example.org/lints.html#{code}" };
  const session = await Session.start([place], { settings, initializationOptions: settings });
  await session.open(file);
  const found = await session.finding(file, "stale-comment");
  assert.equal(found.codeDescription?.href, "https://example.org/lints.html#stale-comment");
  await session.end();
});

for (const [kind, edit] of [
  ["documentChanges", true],
  ["changes", false],
] as const) {
  test(`a quick fix corrects the text, as ${kind}`, async () => {
    const place = folder({ "a.frag": wrongComment.replaceAll("\n", "\r\n") });
    const file = path.join(place, "a.frag");
    const workspace = { ...usual.workspace, workspaceEdit: { documentChanges: edit } };
    const session = await Session.start([place], { capabilities: { ...usual, workspace } });
    await session.open(file);
    const found = await session.finding(file, "stale-comment");
    const actions = await session.actions(file, found.range, ["quickfix"]);
    const fix = actions.find((one) => one.isPreferred === true);
    assert(fix?.edit !== undefined);
    assert.equal(kind in fix.edit, true);
    const fixed = session.applied(fix.edit).get(uri(file));
    assert.equal(fixed, wrongComment.replace("offset 12", "offset 16").replaceAll("\n", "\r\n"));
    await session.end();
  });
}

test("a comment allows a finding in its line or its file", async () => {
  const place = folder({ "a.frag": wrongComment });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  for (const title of [/^Allow .* in this line$/, /^Allow .* in this file$/]) {
    const found = await session.finding(file, "stale-comment");
    const { edit } = only(await session.actions(file, found.range), title);
    assert(edit !== undefined);
    const allowed = session.applied(edit).get(uri(file)) ?? "";
    assert.match(allowed, /landfall: allow(-file)?\(stale-comment\)/);
    assert(allowed.includes("vec3 b; // offset 12"), "the rest of the text stays");
    await session.edit(file, { range: session.range(file, session.text(file)), text: allowed });
    await session.withoutFinding(file, "stale-comment");
    assert(!session.codes(file).includes("unused-allow"));
    await session.edit(file, { range: session.range(file, session.text(file)), text: wrongComment });
  }
  await session.end();
});

test("all fixes of a file are one action, where it is asked for", async () => {
  const text = wrongComment.replace("offset 0", "offset 4");
  const place = folder({ "a.frag": text });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const found = await session.finding(file, "stale-comment");
  const all = await session.actions(file, found.range, ["source.fixAll"]);
  assert.equal(all.length, 1);
  const edit = all[0]?.edit;
  assert(edit !== undefined);
  const expected = wrongComment.replace("offset 12", "offset 16");
  assert.equal(session.applied(edit).get(uri(file)), expected);
  const usualActions = await session.actions(file, found.range);
  assert(!usualActions.some((one) => one.kind === "source.fixAll"), "not in the bulb");
  const parent = await session.actions(file, found.range, ["source"]);
  assert.equal(parent.length, 1, "a kind stands for those below it");
  await session.end();
});

test("drift from the lock is found, and the lock written only when it is accepted", async () => {
  const place = folder({
    "a.frag": wrongComment.replace("offset 12", "offset 16"),
    "landfall.toml": "",
    "layouts/.gitkeep": "",
  });
  const file = path.join(place, "a.frag");
  const lock = path.join(place, "layouts/a.frag.json");
  const session = await Session.start([place]);
  await session.open(file);
  const missing = await session.finding(file, "lock-missing");
  const accept = async (title: RegExp) => {
    const range = (await session.finding(file, title.source.includes("Lock") ? "lock-missing" : "layout-drift")).range;
    const { command } = only(await session.actions(file, range), title);
    assert(command !== undefined);
    await session.request("workspace/executeCommand", { command: command.command, arguments: command.arguments });
  };
  assert.equal(missing.range.start.line >= 0, true);
  assert(!existsSync(lock));
  await accept(/^Lock /);
  await session.withoutFinding(file, "lock-missing");
  const first = readFileSync(lock, "utf8");
  // A member before the others moves them: by 16 bytes.
  await session.replace(file, "    vec3 a;", "    vec4 before;\n    vec3 a;");
  await session.finding(file, "layout-drift");
  assert.equal(readFileSync(lock, "utf8"), first, "nothing is written that was not asked for");
  await accept(/^Accept /);
  await session.withoutFinding(file, "layout-drift");
  const offsets = (text: string) => [...text.matchAll(/"offset": ?(\d+)/g)].map(([, offset]) => Number(offset));
  assert.deepEqual(offsets(first), [0, 16]);
  assert.deepEqual(offsets(readFileSync(lock, "utf8")), [0, 16, 32]);
  await session.end();
});

test("a lock that a newer version wrote is not overwritten", async () => {
  const place = folder({ "a.frag": wrongComment, "landfall.toml": "" });
  const [file, lock] = [path.join(place, "a.frag"), path.join(place, "layouts/a.frag.json")];
  execFileSync(program, ["lock", "--quiet"], { cwd: place });
  const newer = readFileSync(lock, "utf8").replace(/"schema_version": \d+/, '"schema_version": 99');
  write(lock, newer);
  const session = await Session.start([place]);
  await session.open(file);
  const finding = await session.finding(file, "unreadable-lock");
  assert.deepEqual(finding.range, session.range(file, "Block"), "at the first block");
  assert.equal(finding.relatedInformation?.[0]?.location.uri, uri(lock));
  const accept = { command: "landfall.acceptLayout", arguments: [uri(file)] };
  await assert.rejects(session.request("workspace/executeCommand", accept));
  assert.equal(readFileSync(lock, "utf8"), newer);
  await session.end();
});

test("folders that lead to themselves end", async () => {
  const place = folder({ "a.frag": wrongComment, "below/b.frag": wrongComment });
  symlinkSync(place, path.join(place, "below/circle"));
  symlinkSync(path.join(place, "self"), path.join(place, "self"));
  const session = await Session.start([place]);
  await session.finding(path.join(place, "a.frag"), "stale-comment");
  await session.finding(path.join(place, "below/b.frag"), "stale-comment");
  assert.equal(session.findings.size, 2, "each file once");
  await session.end();
});

test("a document that is closed with changes counts as it is on disk", async () => {
  const place = folder({ "a.frag": wrongComment, "landfall.toml": "" });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  await session.finding(file, "stale-comment");
  await session.replace(file, "offset 12", "offset 16");
  await session.withoutFinding(file, "stale-comment");
  await session.close(file);
  // The file still says 12.
  await session.finding(file, "stale-comment");
  await session.open(file, wrongComment.replace("offset 12", "offset 16"));
  await session.withoutFinding(file, "stale-comment");
  await session.end();
});

test(
  "a document that is opened with unsaved changes counts so while the first pass runs",

  async () => {
    const files = Object.fromEntries(Array.from({ length: 40 }, (_, at) => [`${at}.frag`, wrongComment]));
    const place = folder({ ...files, "landfall.toml": "" });
    const file = path.join(place, "0.frag");
    for (let round = 0; round < 5; round += 1) {
      const session = new Session();
      await session.initialize([place]);
      // Each round a little later.
      await new Promise((resolve) => setTimeout(resolve, 2 * round));
      await session.open(file, wrongComment.replace("offset 12", "offset 16"));
      await session.finding(path.join(place, "39.frag"), "stale-comment");
      await session.request("workspace/symbol", { query: "" });
      assert(!session.codes(file).includes("stale-comment"), `round ${round}`);
      await session.end();
    }
  },
);

test("findings of a document of no folder go when it is closed", async () => {
  const place = folder({ "a.frag": wrongComment });
  const file = path.join(place, "a.frag");
  const session = await Session.start([]);
  await session.open(file);
  await session.finding(file, "stale-comment");
  await session.close(file);
  await session.withoutFinding(file, "stale-comment");
  await session.end();
});

test("an include counts as it is edited, not as it is saved", async () => {
  const place = folder({
    "a.frag": `#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.glsl"
layout(std140, binding = 0) uniform Block { Shared first; float last; } u;
layout(location = 0) out vec4 colour;
void main() { colour = vec4(u.last); }
`,
    "shared.glsl": "struct Shared { vec4 a; };\n",
    "landfall.toml": 'include = ["."]\n',
  });
  const [file, include] = [path.join(place, "a.frag"), path.join(place, "shared.glsl")];
  const session = await Session.start([place]);
  await session.open(file);
  const offsets = async () => (await session.labels(file, "float last")).filter((one) => one.startsWith("@"));
  assert.deepEqual(await offsets(), ["@0", "@16, +12 padding"]);
  await session.open(include);
  await session.replace(include, "vec4 a;", "vec4 a; mat4 b;");
  // A matrix of four columns of 16 bytes more.
  assert.deepEqual(await offsets(), ["@0", "@80, +12 padding"]);
  assert.equal(readFileSync(include, "utf8"), "struct Shared { vec4 a; };\n");
  // An error there is published there.
  await session.replace(include, "mat4 b;", "nonsense b;");
  await session.until("an error in the include", () => session.codes(include).length > 0);
  await session.close(include);
  await session.until("no error in the include", () => session.codes(include).length === 0);
  assert.deepEqual(await offsets(), ["@0", "@16, +12 padding"]);
  await session.end();
});

test("two roots have a configuration each, and folders come and go", async () => {
  const warns = '[levels]\nscalar-after-vec3 = "warn"\n';
  const text = "#version 450\nlayout(std140, binding = 0) uniform B { vec3 a; float b; } u;\nvoid main() {}\n";
  const strict = folder({ "a.vert": text, "landfall.toml": warns });
  const lax = folder({ "a.vert": text, "landfall.toml": "", "layouts/.gitkeep": "" });
  const later = folder({ "b.vert": text, "landfall.toml": warns });
  const [one, other, third] = [path.join(strict, "a.vert"), path.join(lax, "a.vert"), path.join(later, "b.vert")];
  const session = await Session.start([strict, lax]);
  await session.open(one);
  await session.open(other);
  await session.finding(one, "scalar-after-vec3");
  await session.finding(other, "lock-missing");
  assert(!session.codes(other).includes("scalar-after-vec3"));
  const change = (added: string[], removed: string[]) => {
    const folders = (all: string[]) => all.map((at) => ({ uri: uri(at), name: path.basename(at) }));
    const event = { added: folders(added), removed: folders(removed) };
    return session.notify("workspace/didChangeWorkspaceFolders", { event });
  };
  // Its shaders are checked though none is open.
  await change([later], []);
  await session.finding(third, "scalar-after-vec3");
  await change([], [later]);
  await session.until("no findings of the folder that is gone", () => session.codes(third).length === 0);
  assert(session.codes(one).includes("scalar-after-vec3"));
  await session.end();
});

test("of a configuration that breaks while it is typed, the last good one holds, with a finding", async () => {
  const text = "#version 450\nlayout(std140, binding = 0) uniform B { vec3 a; float b; } u;\nvoid main() {}\n";
  const good = '[levels]\nscalar-after-vec3 = "warn"\n';
  const place = folder({ "a.vert": text, "landfall.toml": good });
  const [file, config] = [path.join(place, "a.vert"), path.join(place, "landfall.toml")];
  const session = await Session.start([place]);
  await session.open(file);
  await session.open(config, good, "toml");
  await session.finding(file, "scalar-after-vec3");
  await session.replace(config, '"warn"', '"warn');
  const fault = await session.until(
    "a finding in landfall.toml",
    () => session.findings.get(uri(config))?.diagnostics[0],
  );
  assert.equal(fault.severity, DiagnosticSeverity.Error);
  assert.equal(fault.range.start.line, 1);
  await session.replace(file, "float b;", "float b; float c;");
  await session.request("workspace/symbol", { query: "" });
  assert(session.codes(file).includes("scalar-after-vec3"));
  await session.replace(config, '"warn', '"allow"');
  await session.withoutFinding(file, "scalar-after-vec3");
  await session.until("no finding in landfall.toml", () => session.codes(config).length === 0);
  // A table that does not exist is a fault of the configuration, at its line.
  await session.edit(config, { range: session.range(config, session.text(config)), text: "\n[nothing]\n" });
  const unknown = await session.until(
    "a finding in landfall.toml",
    () => session.findings.get(uri(config))?.diagnostics[0],
  );
  assert.equal(unknown.range.start.line, 1);
  await session.end();
});

test("a mirror in Rust counts as it is edited", async () => {
  // By std140 both vec3 are aligned to 16: 12 bytes, 4 of padding, 12 bytes, rounded up to 32.
  const right = `// landfall: mirror(Block)
#[repr(C)]
pub struct Mirror { pub a: [f32; 3], pub _a: f32, pub b: [f32; 3], pub _b: f32 }
`;
  const place = folder({
    "a.frag": wrongComment.replace("offset 12", "offset 16"),
    "landfall.toml": "",
    "mirror.rs": right.replace("pub _a: f32, ", ""),
  });
  const mirror = path.join(place, "mirror.rs");
  const session = await Session.start([place]);
  await session.finding(mirror, "rust-mirror");
  await session.open(mirror, right, "rust");
  await session.withoutFinding(mirror, "rust-mirror");
  await session.replace(mirror, "pub _b: f32 ", "");
  await session.finding(mirror, "rust-mirror");
  await session.end();
});

test("files that change on disk are checked again, once the client says so", async () => {
  const place = folder({ "a.frag": wrongComment, "landfall.toml": "" });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.finding(file, "stale-comment");
  const registered = session.asked.find((one) => one.method === "client/registerCapability");
  assert(JSON.stringify(registered?.params).includes("workspace/didChangeWatchedFiles"));
  write(file, wrongComment.replace("offset 12", "offset 16"));
  await session.notify("workspace/didChangeWatchedFiles", { changes: [{ uri: uri(file), type: 2 }] });
  await session.withoutFinding(file, "stale-comment");
  await session.end();
});

test("a file of 2 MiB is checked as it is saved", async () => {
  const place = folder({ "a.frag": wrongComment, "landfall.toml": "" });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file, wrongComment + "// long\n".repeat(1 << 18));
  await session.finding(file, "stale-comment");
  await session.replace(file, "offset 12", "offset 16");
  await session.request("workspace/symbol", { query: "" });
  assert(session.codes(file).includes("stale-comment"));
  await session.end();
});
