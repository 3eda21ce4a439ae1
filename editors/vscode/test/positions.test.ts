// Lines and characters: section "Position" of the specification. A line ends with \n, \r\n or \r; a character
// is counted in the units that `initialize` has settled; past the end of a line is its end.

import assert from "node:assert/strict";
import * as path from "node:path";
import { test } from "node:test";
import type {
  DocumentSymbol,
  Hover,
  InitializeResult,
  Position,
  PositionEncodingKind,
  Range,
} from "vscode-languageserver-protocol";
import { Session, folder, labelOf, uri, usual } from "./client";

// The emoji is 2 units of UTF-16, 4 bytes of UTF-8, 1 character; the umlaut 1, 2 and 1.
const line = "/* \u{1f4a1}\u{e4} */ vec4 a; /* \u{1f4a1} */ vec4 b;";
const shader = ["#version 450", "layout(std140, binding = 0) uniform Block {", line, "} u;", "void main() {}", ""];

function units(encoding: PositionEncodingKind, text: string): number {
  switch (encoding) {
    case "utf-8":
      return Buffer.byteLength(text);
    case "utf-32":
      return [...text].length;
    default:
      return text.length;
  }
}

for (const encoding of ["utf-16", "utf-8", "utf-32"]) {
  for (const [name, end] of [
    ["\\n", "\n"],
    ["\\r\\n", "\r\n"],
    ["\\r", "\r"],
  ] as const) {
    test(`columns behind an emoji in ${encoding}, lines that end with ${name}`, async () => {
      const place = folder({ "a.frag": shader.join(end) });
      const file = path.join(place, "a.frag");
      const session = new Session();
      const offered = encoding === "utf-16" ? ["utf-16"] : [encoding, "utf-16"];
      const capabilities = { ...usual, general: { positionEncodings: offered } };
      const { capabilities: has }: InitializeResult = await session.initialize([place], { capabilities });
      assert.equal(has.positionEncoding, encoding);
      await session.open(file);
      const column = (part: string) => units(encoding, line.slice(0, line.indexOf(part)));
      const [block] = await session.request<DocumentSymbol[]>("textDocument/documentSymbol", {
        textDocument: { uri: uri(file) },
      });
      const members = block?.children?.map((one) => [one.name, one.selectionRange] as const);
      const own = (part: string): Range => {
        const start = { line: 2, character: column(part) };
        return { start, end: { line: 2, character: start.character + 1 } };
      };
      assert.deepEqual(members, [
        ["a", own("a;")],
        ["b", own("b;")],
      ]);
      const hover = await session.request<Hover | null>("textDocument/hover", {
        textDocument: { uri: uri(file) },
        position: own("b;").start,
      });
      assert.deepEqual(hover?.range, own("b;"));
      // Behind the declarators, in the same units.
      const hints = (await session.hints(file)).filter((one) => one.position.line === 2);
      assert.deepEqual(
        hints.map((one) => one.position),
        [own("a;").end, own("b;").end],
      );
      await session.end();
    });
  }
}

test("a client that names no units counts UTF-16", async () => {
  const session = new Session();
  const { general: _, ...capabilities } = usual;
  const { capabilities: has } = await session.initialize([folder({})], { capabilities });
  assert.equal(has.positionEncoding ?? "utf-16", "utf-16");
  await session.end();
});

test("positions past an end are that end, or nothing is there", async () => {
  const place = folder({ "a.frag": shader.join("\n") });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const far: Position[] = [
    { line: 0, character: 4_000_000_000 },
    { line: 4_000_000_000, character: 0 },
    { line: 2, character: 4 }, // inside the pair of surrogates
    { line: 5, character: 1 },
  ];
  for (const method of ["hover", "definition", "declaration", "implementation", "prepareRename"]) {
    for (const position of far) {
      const asked = session.request(`textDocument/${method}`, { textDocument: { uri: uri(file) }, position });
      await asked.catch((cause: { code: number }) => assert(cause.code !== -32603, method));
    }
  }
  // Text past the end of a line goes to its end, as the client has it, too.
  await session.edit(file, {
    range: { start: { line: 0, character: 900 }, end: { line: 0, character: 999 } },
    text: " // \u{1f4a1}",
  });
  await session.edit(file, {
    range: { start: { line: 99, character: 0 }, end: { line: 99, character: 5 } },
    text: "// end\n",
  });
  assert.deepEqual(await session.labels(file, "vec4 a"), ["@0", "@16"]);
  await session.end();
});

test("a change whose range is none changes nothing", async () => {
  const place = folder({ "a.frag": shader.join("\n") });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const before = await session.hints(file);
  const ends = [-1, 0.5, 2 ** 40, "0", null];
  for (const [at, line] of ends.entries()) {
    const range = { start: { line, character: 0 }, end: { line: 1, character: 0 } };
    await session.notify("textDocument/didChange", {
      textDocument: { uri: uri(file), version: 2 + at },
      contentChanges: [{ range, text: "nothing" }],
    });
  }
  assert.deepEqual(await session.hints(file), before);
  await session.end();
});

test("a document with a byte-order mark has no other columns", async () => {
  const text = "layout(std140) uniform B { vec4 a; };\n";
  const place = folder({ "a.frag": text });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file, `\u{feff}${text}`);
  const hints = await session.hints(file);
  const member = hints.find((one) => labelOf(one) === "@0");
  // The mark is a code unit of the text that the client has.
  assert.equal(member?.position.character, 1 + text.indexOf(";"));
  await session.end();
});

test("after random edits the server has the text that the client has", async () => {
  const place = folder({ "a.frag": shader.join("\r\n") });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  let seed = 12_345;
  const random = (below: number) => {
    seed = (seed * 48_271) % 2_147_483_647; // the minimal standard generator of Park and Miller
    return seed % below;
  };
  const pieces = [
    "",
    "\n",
    "\r\n",
    "\u{1f4a1}",
    "vec3 c;",
    "float d[3];",
    "}",
    "{",
    "/*",
    "*/",
    " ",
    "struct S { vec2 e; };",
    "\u{e4}",
  ];
  for (let round = 0; round < 40; round += 1) {
    const changes = Array.from({ length: 5 }, () => {
      const document = session.document(file);
      const position = () => {
        const at = document.positionAt(random(document.getText().length + 1));
        return at;
      };
      const [a, b] = [position(), position()];
      const forward = a.line < b.line || (a.line === b.line && a.character <= b.character);
      // Long deletions would leave nothing to edit.
      const near = (from: Position): Position => document.positionAt(document.offsetAt(from) + random(4));
      const start = forward ? a : b;
      return { range: { start, end: near(start) }, text: pieces[random(pieces.length)] ?? "" };
    });
    for (const change of changes) {
      await session.edit(file, change);
    }
  }
  // The same text, opened at once, by a server that saw no edits.
  await session.edit(file, { range: session.range(file, session.text(file)), text: `${session.text(file)}\n` });
  const fresh = await Session.start([place]);
  await fresh.open(file, session.text(file));
  const symbols = (one: Session) => one.request("textDocument/documentSymbol", { textDocument: { uri: uri(file) } });
  assert.deepEqual(await session.hints(file), await fresh.hints(file));
  assert.deepEqual(await symbols(session), await symbols(fresh));
  // And text that has layouts, in its place.
  await session.edit(file, { range: session.range(file, session.text(file)), text: shader.join("\n") });
  assert.deepEqual(await session.labels(file, "vec4 a"), ["@0", "@16"]);
  await session.end();
  await fresh.end();
});
