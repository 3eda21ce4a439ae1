// Bundles the extension, its tests, or a package of it: node build.mjs [tests | package [FOLDER]]
//
// `package` writes FOLDER/landfall-vscode-VERSION.vsix, with the version of the command.

import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readdirSync, readFileSync, rmSync } from "node:fs";
import * as path from "node:path";
import { build } from "esbuild";

const here = import.meta.dirname;
const root = path.join(here, "../..");
const node = { bundle: true, platform: "node", target: "node20", logLevel: "warning", absWorkingDir: here };

async function extension() {
  rmSync(path.join(here, "dist"), { recursive: true, force: true });
  await build({
    ...node,
    entryPoints: ["src/extension.ts"],
    outfile: "dist/extension.js",
    format: "cjs",
    external: ["vscode"],
    // Of packages that have both, the modules bundle to less.
    mainFields: ["module", "main"],
    minify: true,
    legalComments: "inline",
  });
}

async function tests() {
  rmSync(path.join(here, "out"), { recursive: true, force: true });
  const names = readdirSync(path.join(here, "test")).filter((name) => name.endsWith(".test.ts"));
  await build({
    ...node,
    entryPoints: names.map((name) => `test/${name}`),
    outdir: "out",
    format: "cjs",
    outExtension: { ".js": ".cjs" },
    sourcemap: "inline",
  });
}

async function vsix(folder) {
  await extension();
  const licences = ["LICENSE-MIT", "LICENSE-APACHE"];
  const manifest = readFileSync(path.join(root, "Cargo.toml"), "utf8");
  const version = manifest.match(/^version = "(.*)"$/m)[1];
  mkdirSync(folder, { recursive: true });
  const out = path.join(folder, `landfall-vscode-${version}.vsix`);
  for (const name of licences) {
    copyFileSync(path.join(root, name), path.join(here, name));
  }
  const vsce = path.join(here, "node_modules/@vscode/vsce/vsce");
  const given = ["package", version, "--no-update-package-json", "--no-git-tag-version", "--no-dependencies"];
  const lacks = ["--allow-missing-repository", "--skip-license"];
  try {
    execFileSync(process.execPath, [vsce, ...given, ...lacks, "--out", out], { cwd: here, stdio: "inherit" });
  } finally {
    licences.forEach((name) => rmSync(path.join(here, name)));
  }
}

const [what = "extension", folder = path.join(root, "target")] = process.argv.slice(2);
switch (what) {
  case "extension":
    await extension();
    break;
  case "tests":
    await tests();
    break;
  case "package":
    await vsix(path.resolve(folder));
    break;
  default:
    console.error(`error: \`${what}\` is neither \`tests\` nor \`package\``);
    process.exit(2);
}
