// The commands: each finds what the cursor is in and has the server do the rest.

import * as vscode from "vscode";
import { ExecuteCommandRequest } from "vscode-languageclient/node";
import { type Server, shaders } from "./client";
import { blockAt, conditionNames, functionAt } from "./places";
import { withoutShowing } from "./results";

/** What the server answers to a command that ran a process. */
interface Output {
  readonly code: number;
  readonly text: string;
  readonly messages: string;
}

export function registerCommands(server: Server): vscode.Disposable[] {
  const commands: Record<string, (...given: unknown[]) => Promise<unknown>> = {
    showMemoryMap: () =>
      ofBlock(async (editor, block) => run(server, "memoryMap", `Memory map of ${block}`, [uriOf(editor), block])),
    copyAsRust: () => copy(server, "rust", "Rust"),
    copyAsC: () => copy(server, "c", "C"),
    verifyBlock: () =>
      ofBlock(async (editor, block) => run(server, "verify", `Verify ${block}`, [uriOf(editor), block])),
    stressFunction: () => stress(server),
    explainRule: (code) => explain(server, code),
    chooseTargets: () => choose("targets", "Targets whose limits and dialect apply", targets, undefined),
    chooseDefines: () => choose("defines", "Macros", namesOf("macros"), "NAME or NAME=TEXT"),
    chooseFeatures: () => choose("features", "Features of WESL", namesOf("features"), "NAME or NAME=false"),
    restartServer: async () => {
      await server.stop();
      await server.start();
    },
    showLog: async () => server.log.show(),
  };
  return Object.entries(commands).map(([name, run]) => vscode.commands.registerCommand(`landfall.${name}`, run));
}

/** Runs a command of the server; progress is shown, and ends the command where it is cancelled. */
async function run(server: Server, command: string, title: string, given: unknown[]): Promise<Output | undefined> {
  const client = await server.running();
  if (client === undefined) {
    return undefined;
  }
  const options = { location: vscode.ProgressLocation.Notification, title: `Landfall: ${title}`, cancellable: true };
  return vscode.window.withProgress(options, async (_, cancelled) => {
    try {
      const params = { command: `landfall.${command}`, arguments: given };
      return (await client.sendRequest(ExecuteCommandRequest.type, params, cancelled)) as Output;
    } catch (cause) {
      if (!cancelled.isCancellationRequested) {
        void vscode.window.showErrorMessage(`Landfall: ${cause instanceof Error ? cause.message : String(cause)}`);
      }
      return undefined;
    }
  });
}

async function copy(server: Server, language: string, title: string): Promise<void> {
  await ofBlock(async (editor, block) => {
    const given = [uriOf(editor), block, language];
    const output = await withoutShowing(() => run(server, "emit", `${block} as ${title}`, given));
    if (output !== undefined) {
      await vscode.env.clipboard.writeText(output.text);
      vscode.window.setStatusBarMessage(`Mirrors in ${title} are in the clipboard`, 5000);
    }
  });
}

async function stress(server: Server): Promise<void> {
  await ofShader(async (editor) => {
    const cursor = editor.document.offsetAt(editor.selection.active);
    const name = await vscode.window.showInputBox({
      title: "Stress: search for inputs at which a function is inaccurate",
      prompt: "The function, or an overload such as f(vec3, float)",
      value: functionAt(editor.document.getText(), cursor) ?? "",
    });
    if (name !== undefined && name !== "") {
      await run(server, "stress", `Stress ${name}`, [uriOf(editor), name]);
    }
  });
}

async function explain(server: Server, given: unknown): Promise<void> {
  const code = typeof given === "string" ? given : await chooseCode();
  if (code !== undefined && code !== "") {
    await run(server, "rule", code, [code]);
  }
}

/** The code of a finding of the document, those at the cursor first, or one that is typed. */
async function chooseCode(): Promise<string | undefined> {
  const editor = vscode.window.activeTextEditor;
  const found = editor === undefined ? [] : vscode.languages.getDiagnostics(editor.document.uri);
  const own = found.filter((one) => one.source === "landfall");
  const line = editor?.selection.active.line ?? 0;
  own.sort((a, b) => Math.abs(a.range.start.line - line) - Math.abs(b.range.start.line - line));
  const codes = own.map(({ code }) => String(typeof code === "object" ? code.value : code));
  const distinct = [...new Set(codes)];
  return distinct.length > 0
    ? vscode.window.showQuickPick(distinct, { title: "Lint to explain" })
    : vscode.window.showInputBox({ title: "Lint to explain", placeHolder: "vec3-array" });
}

function uriOf(editor: vscode.TextEditor): string {
  return editor.document.uri.toString();
}

async function ofShader(run: (editor: vscode.TextEditor) => Promise<unknown>): Promise<void> {
  const editor = vscode.window.activeTextEditor;
  const isShader = (one: vscode.TextEditor) => vscode.languages.match(shaders as vscode.DocumentSelector, one.document);
  if (editor === undefined || isShader(editor) === 0) {
    void vscode.window.showInformationMessage("Landfall: open a shader for this command.");
    return;
  }
  await run(editor);
}

/** Runs something with the block at the cursor, or one that is chosen. */
async function ofBlock(run: (editor: vscode.TextEditor, block: string) => Promise<unknown>): Promise<void> {
  await ofShader(async (editor) => {
    const symbols = await symbolsOf(editor.document.uri);
    const names = symbols.map((one) => one.name);
    if (names.length === 0) {
      void vscode.window.showInformationMessage("Landfall: this shader has no block.");
      return;
    }
    const here = blockAt(symbols, editor.selection.active)?.name;
    const block = here ?? (await vscode.window.showQuickPick(names, { title: "Block" }));
    if (block !== undefined) {
      await run(editor, block);
    }
  });
}

/** The blocks and structures of a document; those of other extensions are of other kinds or have no bytes. */
async function symbolsOf(uri: vscode.Uri): Promise<vscode.DocumentSymbol[]> {
  const all = await vscode.commands.executeCommand<vscode.DocumentSymbol[]>(
    "vscode.executeDocumentSymbolProvider",
    uri,
  );
  return (all ?? []).filter((one) => one.kind === vscode.SymbolKind.Struct && one.detail.includes("byte"));
}

const targets = async () => ["gl33", "gles30", "vulkan", "webgl2", "webgpu"];

function namesOf(kind: "macros" | "features"): () => Promise<string[]> {
  return async () => {
    const text = vscode.window.activeTextEditor?.document.getText() ?? "";
    return conditionNames(text)[kind];
  };
}

/** Has values of a setting chosen, among those it has and others, and writes them to the workspace. */
async function choose(
  setting: string,
  title: string,
  others: () => Promise<string[]>,
  typed: string | undefined,
): Promise<void> {
  const configuration = vscode.workspace.getConfiguration("landfall");
  const now = configuration.get<string[]>(setting, []);
  const more = (await others()).filter((name) => !now.some((one) => one.split("=")[0] === name));
  const other = "Another…";
  const items: vscode.QuickPickItem[] = [
    ...now.map((label) => ({ label, picked: true })),
    ...more.map((label) => ({ label })),
    ...(typed === undefined ? [] : [{ label: other, description: typed }]),
  ];
  const picked = await vscode.window.showQuickPick(items, { title, canPickMany: true });
  if (picked === undefined) {
    return;
  }
  const values = picked.map((one) => one.label).filter((label) => label !== other);
  if (picked.some((one) => one.label === other)) {
    const value = await vscode.window.showInputBox({ title, prompt: typed ?? "" });
    values.push(...(value === undefined || value === "" ? [] : [value]));
  }
  const hasFolder = vscode.workspace.workspaceFolders !== undefined;
  const where = hasFolder ? vscode.ConfigurationTarget.Workspace : vscode.ConfigurationTarget.Global;
  await configuration.update(setting, values.length > 0 ? values : undefined, where);
}
