// From names to their declarations, uses and Rust fields, and renames.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import * as path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import type { Location, WorkspaceEdit } from "vscode-languageserver-protocol";
import { Session, folder, program, uri } from "./client";

const files = {
  "landfall.toml": 'include = ["."]\n',
  // Locks, so that each shader has a finding when it was checked.
  "layouts/.gitkeep": "",
  "shared.glsl": "struct Light { vec3 colour; float radius; };\n",
  "a.frag": `#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.glsl"
layout(std140, binding = 0) uniform Lights { Light lights[4]; } u;
layout(location = 0) out vec4 result;
void main() { result = vec4(u.lights[0].colour, u.lights[1].radius); }
`,
  "b.frag": `#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.glsl"
layout(std140, binding = 1) uniform One { Light light; } one;
layout(location = 0) out vec4 result;
void main() { result = vec4(one.light.radius); }
`,
  "mirror.rs": `// landfall: mirror(Light)
#[repr(C)]
pub struct GpuLight {
    pub colour: [f32; 3],
    pub radius: f32,
}
`,
};

/** The text at a place of a file. */
function textAt({ uri: at, range }: Location): string {
  const text = readFileSync(fileURLToPath(at), "utf8").split("\n")[range.start.line] ?? "";
  return `${path.basename(fileURLToPath(at))}:${range.start.line + 1}:${text.slice(range.start.character, range.end.character)}`;
}

/** A session in which all shaders were checked. */
async function checked(more: Record<string, string> = {}): Promise<{ session: Session; place: string }> {
  const place = folder({ ...files, ...more });
  const session = await Session.start([place]);
  const shaders = Object.keys({ ...files, ...more }).filter((name) => name.endsWith(".frag"));
  for (const name of shaders) {
    await session.finding(path.join(place, name), "lock-missing");
  }
  return { session, place };
}

test("a use leads to its declaration in the include, and that to all uses", async () => {
  const { session, place } = await checked();
  const file = path.join(place, "a.frag");
  await session.open(file);
  const radius = session.at(file, "radius);");
  const definition = await session.request<Location[]>("textDocument/definition", radius);
  assert.deepEqual(definition.map(textAt), ["shared.glsl:1:radius"]);
  const uses = await session.request<Location[]>("textDocument/references", {
    ...radius,
    context: { includeDeclaration: true },
  });
  assert.deepEqual(uses.map(textAt).sort(), ["a.frag:6:radius", "b.frag:6:radius", "shared.glsl:1:radius"]);
  const others = await session.request<Location[]>("textDocument/references", {
    ...radius,
    context: { includeDeclaration: false },
  });
  assert.deepEqual(others.map(textAt).sort(), ["a.frag:6:radius", "b.frag:6:radius"]);
  const include = await session.request<Location[]>("textDocument/definition", session.at(file, "shared.glsl"));
  assert.deepEqual(include.map(textAt), ["shared.glsl:1:"]);
  await session.end();
});

test("a member leads to the field of Rust that feeds it, and back", async () => {
  const { session, place } = await checked();
  const [file, mirror] = [path.join(place, "a.frag"), path.join(place, "mirror.rs")];
  const include = path.join(place, "shared.glsl");
  await session.open(file);
  await session.open(include);
  const fields = await session.request<Location[]>("textDocument/implementation", session.at(include, "radius"));
  assert.deepEqual(fields.map(textAt), ["mirror.rs:5:radius"]);
  await session.open(mirror, undefined, "rust");
  const members = await session.request<Location[]>("textDocument/declaration", session.at(mirror, "radius"));
  assert.deepEqual(members.map(textAt), ["shared.glsl:1:radius"]);
  const structure = await session.request<Location[]>("textDocument/declaration", session.at(mirror, "GpuLight"));
  assert.deepEqual(structure.map(textAt), ["shared.glsl:1:Light"]);
  // Other requests about Rust are left to others.
  for (const method of ["hover", "definition", "prepareRename"]) {
    const found = await session.request(`textDocument/${method}`, session.at(mirror, "radius")).catch(() => null);
    assert(found === null || (Array.isArray(found) && found.length === 0), method);
  }
  await session.end();
});

test("a member is renamed in all files that have it", async () => {
  const { session, place } = await checked();
  const file = path.join(place, "a.frag");
  await session.open(file);
  const radius = session.at(file, "radius);");
  const prepared = await session.request("textDocument/prepareRename", radius);
  assert.deepEqual(prepared, session.range(file, "radius"));
  const edit = await session.request<WorkspaceEdit>("textDocument/rename", { ...radius, newName: "reach" });
  const texts = session.applied(edit);
  assert.deepEqual(
    [...texts.keys()].sort(),
    ["a.frag", "b.frag", "shared.glsl"].map((one) => uri(path.join(place, one))),
  );
  for (const [at, text] of texts) {
    const name = path.basename(at) as keyof typeof files;
    assert.equal(text, files[name].replaceAll("radius", "reach"));
  }
  await session.end();
});

test("a member of the same name of another structure is not renamed", async () => {
  const other = `#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.glsl"
layout(std140, binding = 1) uniform One { Light light; } one;
layout(location = 0) out vec4 result;
struct Other { float radius; };
void main() { Other other = Other(1.0); result = vec4(one.light.radius + other.radius); }
`;
  const { session, place } = await checked({ "c.frag": other });
  const file = path.join(place, "a.frag");
  await session.open(file);
  const asked = { ...session.at(file, "radius);"), newName: "reach" };
  const edit = await session.request<WorkspaceEdit>("textDocument/rename", asked);
  const renamed = session.applied(edit).get(uri(path.join(place, "c.frag")));
  assert.equal(renamed, other.replace("light.radius", "light.reach"));
  await session.end();
});

test("a rename to a name that is none, or taken, or reserved is refused", async () => {
  const { session, place } = await checked();
  const file = path.join(place, "a.frag");
  await session.open(file);
  // GLSL 4.60, section 3.7: names that begin with gl_ are reserved, and keywords are no names.
  for (const newName of ["1a", "", "a b", "radius", "float", "gl_Position"]) {
    await assert.rejects(
      session.request("textDocument/rename", { ...session.at(file, "colour,"), newName }),
      `\`${newName}\``,
    );
  }
  await session.end();
});

test("a rename leaves what is not the member, or is refused", async () => {
  const shadowed = `#version 450
layout(std140, binding = 0) uniform B { float gain; };
layout(location = 0) out vec4 result;
float f(float gain) { return gain; }
void main() { result = vec4(gain + f(1.0)); }
`;
  const branched = `#version 450
layout(std140, binding = 0) uniform C {
#ifdef X
    float gain;
#else
    vec2 gain;
#endif
};
layout(location = 0) out vec4 result;
void main() { result = vec4(gain.x); }
`;
  const place = folder({ "shadowed.frag": shadowed, "branched.frag": branched, "layouts/.gitkeep": "" });
  const [one, other] = [path.join(place, "shadowed.frag"), path.join(place, "branched.frag")];
  const session = await Session.start([place]);
  await session.finding(one, "lock-missing");
  await session.finding(other, "lock-missing");
  await session.open(one);
  await session.open(other);
  const renamed = async (file: string, part: string) => {
    const asked = { ...session.at(file, part), newName: "reach" };
    const edit = await session.request<WorkspaceEdit>("textDocument/rename", asked).catch(() => undefined);
    return edit === undefined ? "refused" : session.applied(edit).get(uri(file));
  };
  // The parameter hides the member.
  const expected = shadowed.replace("float gain; }", "float reach; }").replace("vec4(gain", "vec4(reach");
  assert([expected, "refused"].includes((await renamed(one, "gain;")) ?? ""), await renamed(one, "gain;"));
  // Under X the name would be gone.
  const both = branched.replaceAll("gain", "reach");
  assert([both, "refused"].includes((await renamed(other, "gain.x")) ?? ""), await renamed(other, "gain.x"));
  await session.end();
});

test("symbols of a document and of all shaders", async () => {
  const { session, place } = await checked();
  const file = path.join(place, "a.frag");
  await session.open(file);
  type Named = { name: string; children?: Named[]; detail?: string };
  const symbols = await session.request<Named[]>("textDocument/documentSymbol", { textDocument: { uri: uri(file) } });
  assert.deepEqual(
    symbols.map((one) => [one.name, one.children?.map((child) => child.name)]),
    [["Lights", ["lights"]]],
  );
  const all = await session.request<Named[]>("workspace/symbol", { query: "" });
  assert.deepEqual(all.map((one) => one.name).sort(), ["Lights", "One"]);
  const some = await session.request<Named[]>("workspace/symbol", { query: "lts" });
  assert.deepEqual(
    some.map((one) => one.name),
    ["Lights"],
  );
  await session.end();
});

test("every edit of a rename leaves shaders that the command finds nothing new in", async () => {
  const { session, place } = await checked();
  const file = path.join(place, "a.frag");
  await session.open(file);
  const edit = await session.request<WorkspaceEdit>("textDocument/rename", {
    ...session.at(file, "colour,"),
    newName: "hue",
  });
  const texts = session.applied(edit);
  const renamed = folder({
    ...files,
    ...Object.fromEntries([...texts].map(([at, text]) => [path.basename(at), text])),
  });
  const layouts = (at: string) => {
    const output = execFileSync(program, ["layout", "--format", "json", "-I", at, path.join(at, "a.frag")], {
      encoding: "utf8",
    });
    return [...output.matchAll(/"offset": ?(\d+)/g)].map(([, offset]) => offset);
  };
  assert.deepEqual(layouts(renamed), layouts(place));
  await session.end();
});
