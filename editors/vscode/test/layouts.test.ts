// Hints and hovers on shaders whose offsets are worked out from the specifications: OpenGL 4.6, section
// 7.6.2.2, for std140 and std430; WGSL, section 14.4.1, for the alignments and sizes of its types.

import assert from "node:assert/strict";
import * as path from "node:path";
import { test } from "node:test";
import type { Hover, MarkupContent } from "vscode-languageserver-protocol";
import { Session, folder, labelOf } from "./client";

const glsl = `#version 450
struct Light {
    vec3 position;
    float range;
    mat3 rotation;
};
layout(std140, binding = 0) uniform Uniforms {
    float time;
    vec3 eye;
    float weights[3];
    Light lights[2];
} u;
layout(std430, binding = 1) buffer Storage {
    float time;
    vec3 eye;
    float weights[3];
    Light lights[2];
} s;
layout(location = 0) out vec4 colour;
void main() { colour = vec4(u.eye, s.time); }
`;

/** Settings with which all that is known is shown. */
const everything = { inlayHints: { offsets: true, sizes: true, strides: true, padding: true, blocks: true } };

/** The numbers of a label: those after `@`, before `byte`, after `stride`, and with `padding`. */
function numbers(label: string) {
  const one = (pattern: RegExp) => {
    const found = label.match(pattern)?.[1];
    return found === undefined ? undefined : Number(found);
  };
  return {
    offset: one(/@(\d+)/),
    size: one(/\b(\d+) bytes?\b/),
    stride: one(/stride (\d+)/),
    before: one(/\b(\d+) padding before/),
    after: one(/\+(\d+) padding/),
  };
}

/** Opens one shader with all hints on; returns the labels of the line of each given piece. */
async function labelled(name: string, text: string, pieces: string[]): Promise<string[][]> {
  const place = folder({ [name]: text });
  const file = path.join(place, name);
  const session = await Session.start([place], { settings: everything, initializationOptions: everything });
  await session.open(file);
  const found = [];
  for (const piece of pieces) {
    found.push(await session.labels(file, piece));
  }
  await session.end();
  return found;
}

// GLSL's members, by hand. std140: a vec3 is aligned to 16; elements of arrays are 16 apart; mat3 is three
// columns, 16 apart; the structure is rounded up to 16. std430: the floats of the array are 4 apart.
test("members of std140 and std430 are where the OpenGL specification has them", async () => {
  const [block] = await labelled("a.frag", glsl, ["uniform Uniforms"]);
  assert.match(block?.join() ?? "", /208 bytes.*std140/);
  const place = folder({ "a.frag": glsl });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place], { settings: everything, initializationOptions: everything });
  await session.open(file);
  const hints = await session.hints(file);
  const inLine = (line: number) =>
    hints.filter((one) => one.position.line === line).map((one) => numbers(labelOf(one)))[0];
  const none = undefined;
  // Uniforms: time 0..4; 12 of padding; eye 16..28; weights: 3 * 16 from 32; lights from 80, 64 each.
  assert.deepEqual(inLine(7), { offset: 0, size: 4, stride: none, before: none, after: 12 });
  assert.deepEqual(inLine(8), { offset: 16, size: 12, stride: none, before: none, after: 4 });
  assert.deepEqual(inLine(9), { offset: 32, size: 48, stride: 16, before: none, after: none });
  assert.deepEqual(inLine(10), { offset: 80, size: 128, stride: 64, before: none, after: none });
  // Storage: time 0..4; eye 16..28; weights: 3 * 4 from 28; lights at 48 after 8 of padding.
  assert.deepEqual(inLine(13), { offset: 0, size: 4, stride: none, before: none, after: 12 });
  assert.deepEqual(inLine(14), { offset: 16, size: 12, stride: none, before: none, after: none });
  assert.deepEqual(inLine(15), { offset: 28, size: 12, stride: 4, before: none, after: 8 });
  assert.deepEqual(inLine(16), { offset: 48, size: 128, stride: 64, before: none, after: none });
  // Light is the same under both rules: 12 + 4 + 48.
  assert.deepEqual(inLine(2), { offset: 0, size: 12, stride: none, before: none, after: none });
  assert.deepEqual(inLine(3), { offset: 12, size: 4, stride: none, before: none, after: none });
  assert.deepEqual(inLine(4), { offset: 16, size: 48, stride: none, before: none, after: none });
  await session.end();
});

test("a structure that two rules place differently has both", async () => {
  const text = `#version 450
struct Pair { float a[2]; };
layout(std140, binding = 0) uniform U { Pair u; };
layout(std430, binding = 1) buffer S { Pair s; };
void main() {}
`;
  const [labels] = await labelled("a.comp", text, ["struct Pair"]);
  const [whole, member] = labels ?? [];
  // A structure is rounded up to 16 in std140 alone; so are the elements of the array.
  assert.match(whole ?? "", /std140: 32 bytes/);
  assert.match(whole ?? "", /std430: 8 bytes/);
  assert.match(member ?? "", /std140: @0, 32 bytes, stride 16/);
  assert.match(member ?? "", /std430: @0, 8 bytes, stride 4/);
});

test("members of WGSL are where its specification has them", async () => {
  const text = `struct Inner { a: vec3<f32>, b: f32 }
struct Outer {
    flag: u32,
    direction: vec3<f32>,
    @size(32) wide: f32,
    matrix: mat3x3<f32>,
    @align(32) inner: Inner,
    list: array<vec3<f32>, 2>,
    half: vec2<f32>,
}
@group(0) @binding(0) var<storage, read> outer: Outer;
`;
  const place = folder({ "a.wgsl": text });
  const file = path.join(place, "a.wgsl");
  const session = await Session.start([place], { settings: everything, initializationOptions: everything });
  await session.open(file);
  const hints = await session.hints(file);
  const inLine = (line: number) =>
    hints.filter((one) => one.position.line === line).map((one) => numbers(labelOf(one)));
  const expected: [number, number, number, number | undefined][] = [
    [2, 0, 4, undefined],
    [3, 16, 12, undefined],
    [4, 28, 32, undefined], // @size(32) from 28, where an f32 may be
    [5, 64, 48, undefined], // roundUp(16, 60)
    [6, 128, 16, undefined], // roundUp(32, 112)
    [7, 144, 32, 16],
    [8, 176, 8, undefined],
  ];
  for (const [line, offset, size, stride] of expected) {
    const [found] = inLine(line);
    assert.deepEqual([found?.offset, found?.size, found?.stride], [offset, size, stride], `line ${line}`);
  }
  // AlignOf(Outer) is 32, so roundUp(32, 184).
  assert.equal(inLine(1)[0]?.size, 192);
  // Bytes of members and of padding cover the structure once: what is not a member's is padding.
  const members = expected.map(([line]) => inLine(line)[0]);
  const covered = members.reduce((sum, one) => sum + (one?.size ?? 0) + (one?.after ?? 0) + (one?.before ?? 0), 0);
  assert.equal(covered, 192);
  await session.end();
});

test("each kind of hint is switched off by its setting", async () => {
  const place = folder({ "a.frag": glsl });
  const file = path.join(place, "a.frag");
  const off = { offsets: false, sizes: false, strides: false, padding: false, blocks: false };
  const session = await Session.start([place], {
    settings: { inlayHints: off },
    initializationOptions: { inlayHints: off },
  });
  await session.open(file);
  assert.deepEqual(await session.hints(file), []);
  const kinds: [string, RegExp, RegExp][] = [
    ["offsets", /@\d/, /bytes|stride|padding/],
    ["sizes", /bytes?\b/, /@|stride|padding/],
    ["strides", /stride/, /@|bytes|padding/],
    ["padding", /padding/, /@|bytes|stride/],
    ["blocks", /bytes/, /@|stride/],
  ];
  for (const [kind, has, lacks] of kinds) {
    session.settings = { inlayHints: { ...off, [kind]: true } };
    await session.followed("workspace/configuration", () => {
      return session.notify("workspace/didChangeConfiguration", { settings: null });
    });
    const labels = (await session.hints(file)).map(labelOf);
    assert(labels.length > 0, kind);
    for (const label of labels) {
      assert.match(label, has, kind);
      assert.doesNotMatch(label, lacks, kind);
    }
  }
  await session.end();
});

test("hints are at declarations alone, and those of the lines that are asked for", async () => {
  const place = folder({ "a.frag": glsl });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const lines = (await session.hints(file)).map((one) => one.position.line);
  assert.deepEqual([...new Set(lines)], [1, 2, 3, 4, 6, 7, 8, 9, 10, 12, 13, 14, 15, 16]);
  const range = { start: { line: 7, character: 0 }, end: { line: 9, character: 0 } };
  const some = await session.request<{ position: { line: number } }[]>("textDocument/inlayHint", {
    textDocument: session.at(file, "u;").textDocument,
    range,
  });
  assert.deepEqual(
    some.map((one) => one.position.line),
    [7, 8],
  );
  await session.end();
});

test("a hover tells the bytes of a member, its rule, and what differs under others", async () => {
  const place = folder({ "a.frag": glsl });
  const file = path.join(place, "a.frag");
  const session = await Session.start([place]);
  await session.open(file);
  const hover = async (part: string, behind = 0) => {
    const at = session.at(file, part);
    at.position.character += behind;
    const found = await session.request<Hover | null>("textDocument/hover", at);
    return { text: (found?.contents as MarkupContent | undefined)?.value ?? "", range: found?.range };
  };
  const { text, range } = await hover("weights[3]");
  assert.match(text, /\b32\b/);
  assert.match(text, /48 bytes/);
  assert.match(text, /std140/);
  // Under std430 and scalar the elements are 4 apart; under scalar a vec3 needs no alignment of 16.
  assert.match(text, /std430: byte 28, 12 bytes/);
  assert.match(text, /scalar: byte 16, 12 bytes/);
  assert.deepEqual(range, session.range(file, "weights"));
  assert.match((await hover("Uniforms")).text, /208 bytes/);
  assert.match((await hover("u.eye", 2)).text, /`eye` of `Uniforms`/, "a use");
  assert.equal((await hover("void")).text, "");
  await session.end();
});
