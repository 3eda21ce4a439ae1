// What of the extension needs no editor, and its manifest against the server.

import assert from "node:assert/strict";
import { chmodSync, readFileSync } from "node:fs";
import * as path from "node:path";
import { test } from "node:test";
import { findProgram, refusal } from "../src/executable";
import { blockAt, conditionNames, functionAt } from "../src/places";
import { codeAt, pagesAt, withPages } from "../src/rules";
import { Session, folder, program, write } from "./client";

const manifest = JSON.parse(readFileSync(path.join(__dirname, "../package.json"), "utf8")) as {
  publisher: string;
  name: string;
  contributes: {
    commands: { command: string }[];
    menus: { commandPalette: { command: string }[] };
    configuration: {
      properties: Record<string, { type: string | string[]; default: unknown; items?: { enum?: string[] } }>;
    };
  };
};

test("a program is found by its path, on the path, and where cargo installs", () => {
  const place = folder({ "bin/landfall.exe": "", "cargo/bin/other": "", plain: "" });
  const variables = { PATH: path.join(place, "bin"), CARGO_HOME: path.join(place, "cargo") };
  const given = process.execPath;
  assert.equal(findProgram(given, {}), given);
  const name = path.basename(given);
  assert.equal(findProgram(name, { ...variables, PATH: path.dirname(given) }), given);
  assert.equal(findProgram(name, { PATH: "", CARGO_HOME: path.join(place, "cargo") }), undefined);
  assert.equal(findProgram("other", variables), undefined, "a file that cannot be run");
  assert.equal(findProgram(place, variables), undefined, "a folder");
});

test("a program that does not serve is known by what it says", async () => {
  const place = folder({
    without: "#!/bin/sh\necho 'error: built without lsp' >&2\nexit 2\n",
    none: "#!/nowhere/sh\n",
  });
  for (const name of ["without", "none"]) {
    chmodSync(path.join(place, name), 0o755);
  }
  assert.equal(await refusal(program), undefined);
  assert.equal(await refusal(path.join(place, "without")), "error: built without lsp");
  assert.match((await refusal(path.join(place, "none"))) ?? "", /ENOENT/);
});

test("the block at a cursor is the one whose lines hold it", () => {
  const symbol = (name: string, from: number, to: number) => {
    return { name, range: { start: { line: from, character: 8 }, end: { line: to, character: 3 } } };
  };
  const symbols = [symbol("A", 2, 5), symbol("B", 8, 9)];
  const at = (line: number) => blockAt(symbols, { line, character: 0 })?.name;
  assert.deepEqual([0, 2, 5, 6, 9].map(at), [undefined, "A", "A", undefined, "B"]);
  assert.equal(blockAt([symbol("A", 2, 5)], { line: 90, character: 0 })?.name, "A", "the only one");
});

test("the function at a cursor is the one whose head is before it", () => {
  const glsl = `float f(float a) { return a; }
// float no(float b) {
vec3[2] g(vec3 v, inout vec3 w)
{
    if (v.x > 0.0) { w = v; } else if (v.y > 0.0) { }
    for (int i = 0; i < 2; i++) { w[i] = 1.0; }
    return vec3[2](v, w);
}
void main() { }
`;
  const names = (text: string, ...pieces: string[]) => pieces.map((piece) => functionAt(text, text.indexOf(piece)));
  assert.deepEqual(names(glsl, "return a", "no(", "w = v", "w[i]", "return vec3", "main"), [
    "f",
    "f",
    "g",
    "g",
    "g",
    "main",
  ]);
  const wgsl = "@fragment\nfn one(a: f32) -> f32 { return a; }\nfn two() { if (x) { y(); } }\n";
  assert.deepEqual(names(wgsl, "@fragment", "return a", "y()"), ["one", "one", "two"]);
  assert.equal(functionAt("struct S { float a; };", 3), undefined);
});

test("the code of a finding opens its page in the editor, unless the settings name another", async () => {
  const place = folder({ "a.frag": "#version 450\nlayout(std140) uniform B { vec3 a[2]; } b;\nvoid main() {}\n" });
  write(path.join(place, "landfall.toml"), '[levels]\nvec3-array = "warn"\n');
  const pages = pagesAt("vscode-insiders");
  for (const [settings, address] of [
    [null, "vscode-insiders://landfall.landfall/rule/vec3-array"],
    [{ rulePages: null }, "vscode-insiders://landfall.landfall/rule/vec3-array"],
    [{ rulePages: "https://example.org/{code}" }, "https://example.org/vec3-array"],
  ] as const) {
    const given = withPages(settings, pages);
    const session = await Session.start([place], { settings: given, initializationOptions: given });
    const finding = await session.finding(path.join(place, "a.frag"), "vec3-array");
    assert.equal(finding.codeDescription?.href, address);
    await session.end();
  }
  assert.equal(codeAt(new URL("vscode://landfall.landfall/rule/vec3-array").pathname), "vec3-array");
  for (const other of ["/rule/", "/rule/a/b", "/rules/vec3-array", "/rule/../x", "/rule/a;b"]) {
    assert.equal(codeAt(other), undefined, other);
  }
  assert.equal(`${manifest.publisher}.${manifest.name}`, "landfall.landfall", "the host of the address");
});

test("the names that conditions ask about", () => {
  const text = `#ifdef FOG
#if defined(SHADOWS) && LIGHTS > 4 || __VERSION__ > 300 || GL_ES
#define NOT_ASKED 1
@if(DEBUG && !FAST) const a = 1;
@elif(OTHER) const a = 2;
`;
  assert.deepEqual(conditionNames(text), {
    macros: ["FOG", "LIGHTS", "SHADOWS"],
    features: ["DEBUG", "FAST", "OTHER"],
  });
});

test("every setting has its default in the server, and a value that the server takes", async () => {
  const place = folder({ "a.frag": "#version 450\nlayout(std140) uniform B { vec3 a[2]; float b; };\n" });
  const file = path.join(place, "a.frag");
  const properties = Object.entries(manifest.contributes.configuration.properties);
  const own = properties.filter(([name]) => !/^landfall\.(server\.path|trace\.server)$/.test(name));
  const nested = (value: (one: (typeof own)[number][1]) => unknown) => {
    const all: Record<string, unknown> = {};
    for (const [name, one] of own) {
      const parts = name.split(".").slice(1);
      const last = parts.pop() as string;
      const holder = parts.reduce((at, part) => (at[part] ??= {}) as Record<string, unknown>, all);
      holder[last] = value(one);
    }
    return all;
  };
  const hints = async (settings: unknown) => {
    const session = await Session.start([place], { settings, initializationOptions: settings });
    await session.open(file);
    const found = await session.hints(file);
    assert(!session.asked.some((one) => one.method === "window/showMessage"), "all are taken");
    await session.end();
    return found;
  };
  assert.deepEqual(await hints(nested((one) => one.default)), await hints(null));
  const other = nested((one) => {
    switch (one.type) {
      case "boolean":
        return true;
      case "array":
        return one.items?.enum ?? ["NAME"];
      default:
        return "https://example.org/{code}";
    }
  });
  assert.notDeepEqual(await hints(other), await hints(null));
});

test("the commands of the extension are none of the server's, which the client registers itself", async () => {
  const session = new Session();
  const { capabilities } = await session.initialize([folder({})]);
  const own = manifest.contributes.commands.map((one) => one.command);
  const theirs = capabilities.executeCommandProvider?.commands ?? [];
  assert(theirs.length > 0);
  assert.deepEqual(
    own.filter((one) => theirs.includes(one)),
    [],
  );
  for (const one of manifest.contributes.menus.commandPalette) {
    assert(own.includes(one.command), one.command);
  }
  await session.end();
});
