// Where the program is that serves.

import { execFile } from "node:child_process";
import { accessSync, constants, statSync } from "node:fs";
import { homedir } from "node:os";
import * as path from "node:path";

/** The file of a program: a path, or a name that is on the path; `undefined` if there is none. */
export function findProgram(
  given: string,
  variables: NodeJS.ProcessEnv = process.env,
  system: NodeJS.Platform = process.platform,
): string | undefined {
  const name = given.replace(/^~(?=[/\\]|$)/, homedir());
  const endings = system === "win32" ? ["", ".exe"] : [""];
  const hasFolder = /[/\\]/.test(name);
  // A program on the path may be missing there for an editor that no shell has started.
  const cargo = path.join(variables.CARGO_HOME ?? path.join(homedir(), ".cargo"), "bin");
  const onPath = (variables.PATH ?? variables.Path ?? "").split(path.delimiter).filter((folder) => folder !== "");
  const folders = hasFolder ? [""] : [...onPath, cargo];
  const files = folders.flatMap((folder) => endings.map((ending) => path.join(folder, name + ending)));
  return files.find(isProgram);
}

function isProgram(file: string): boolean {
  try {
    accessSync(file, constants.X_OK);
    return statSync(file).isFile();
  } catch {
    return false;
  }
}

/**
 * What a program says that does not serve, as one that was built without the server. One that does ends
 * in silence where no client speaks.
 */
export function refusal(program: string): Promise<string | undefined> {
  return new Promise((resolve) => {
    const child = execFile(program, ["lsp"], { timeout: 10_000 }, (error, _, stderr) => {
      const serves = error === null || error.code === 1;
      resolve(serves ? undefined : stderr.trim() || error.message);
    });
    // One that has ended by then reads nothing.
    child.stdin?.on("error", () => {}).end();
  });
}
