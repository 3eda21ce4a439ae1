// A client of the Language Server Protocol that has nothing of the server's: Microsoft's packages read and
// write the messages, apply the edits and count the positions.

import assert from "node:assert/strict";
import { type ChildProcess, execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, realpathSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import * as path from "node:path";
import { after } from "node:test";
import { pathToFileURL } from "node:url";
import {
  type MessageConnection,
  StreamMessageReader,
  StreamMessageWriter,
  createMessageConnection,
} from "vscode-jsonrpc/node";
import type {
  ClientCapabilities,
  CodeAction,
  Diagnostic,
  InitializeResult,
  InlayHint,
  Position,
  PublishDiagnosticsParams,
  Range,
  TextEdit,
  WorkspaceEdit,
} from "vscode-languageserver-protocol";
import { TextDocument } from "vscode-languageserver-textdocument";

/** The program under test. */
export const program = (() => {
  const given = process.env.LANDFALL;
  assert(given !== undefined, "LANDFALL names the program `landfall` under test, built with the feature `lsp`");
  return path.resolve(given);
})();

/** How long an answer may take on a busy machine. */
const patience = 30_000;

/** A folder of files that lives as long as the tests of its file. */
export function folder(files: Record<string, string>): string {
  const made = realpathSync(mkdtempSync(path.join(tmpdir(), "landfall-protocol-")));
  after(() => rmSync(made, { recursive: true, force: true }));
  for (const [name, text] of Object.entries(files)) {
    write(path.join(made, name), text);
  }
  return made;
}

export function write(file: string, text: string): void {
  mkdirSync(path.dirname(file), { recursive: true });
  writeFileSync(file, text);
}

/** What most clients can do. */
export const usual: ClientCapabilities = {
  general: { positionEncodings: ["utf-16"] },
  textDocument: {
    publishDiagnostics: { relatedInformation: true, versionSupport: true },
    codeAction: { codeActionLiteralSupport: { codeActionKind: { valueSet: ["quickfix", "refactor", "source"] } } },
  },
  window: { showDocument: { support: true }, workDoneProgress: true },
  workspace: {
    workspaceEdit: { documentChanges: true },
    workspaceFolders: true,
    configuration: true,
    inlayHint: { refreshSupport: true },
    didChangeWatchedFiles: { dynamicRegistration: true },
  },
};

export interface Options {
  readonly capabilities?: ClientCapabilities;
  readonly settings?: unknown;
  /** Whether requests of the server are answered. */
  readonly answers?: boolean;
  readonly initializationOptions?: unknown;
}

/** A server that runs, and its client. */
export class Session {
  readonly process: ChildProcess;
  readonly connection: MessageConnection;
  readonly exited: Promise<number | null>;
  /** The last findings of each document. */
  readonly findings = new Map<string, PublishDiagnosticsParams>();
  /** The requests and notifications of the server. */
  readonly asked: { method: string; params: unknown }[] = [];
  readonly documents = new Map<string, TextDocument>();
  settings: unknown;
  stderr = "";
  private readonly waiting = new Set<() => void>();

  constructor(options: Options = {}) {
    this.settings = options.settings ?? null;
    this.process = spawn(program, ["lsp"], { stdio: "pipe" });
    const { stdin, stdout, stderr } = this.process;
    assert(stdin !== null && stdout !== null && stderr !== null);
    stderr.on("data", (text: Buffer) => (this.stderr += text.toString()));
    stdin.on("error", () => {}); // one that has ended reads no further
    this.exited = new Promise((resolve) => this.process.once("exit", (code) => resolve(code)));
    this.connection = createMessageConnection(new StreamMessageReader(stdout), new StreamMessageWriter(stdin));
    this.connection.onNotification((method, params) => {
      this.asked.push({ method, params });
      if (method === "textDocument/publishDiagnostics") {
        const found = (Array.isArray(params) ? params[0] : params) as PublishDiagnosticsParams;
        this.findings.set(found.uri, found);
      }
      this.waiting.forEach((look) => look());
    });
    this.connection.onRequest((method, params) => {
      this.asked.push({ method, params });
      this.waiting.forEach((look) => look());
      if (options.answers === false) {
        return new Promise(() => {});
      }
      switch (method) {
        case "workspace/configuration":
          return [this.settings];
        case "window/showDocument":
          return { success: true };
        default:
          return null;
      }
    });
    this.connection.onUnhandledProgress((params) => {
      this.asked.push({ method: "$/progress", params });
      this.waiting.forEach((look) => look());
    });
    this.connection.onError(() => {});
    this.connection.listen();
    after(() => this.process.kill());
  }

  /** Starts a server for folders. */
  static async start(folders: readonly string[], options: Options = {}): Promise<Session> {
    const session = new Session(options);
    await session.initialize(folders, options);
    return session;
  }

  async initialize(folders: readonly string[], options: Options = {}): Promise<InitializeResult> {
    const result: InitializeResult = await this.request("initialize", {
      processId: process.pid,
      rootUri: null,
      capabilities: options.capabilities ?? usual,
      initializationOptions: options.initializationOptions,
      workspaceFolders: folders.map((one) => ({ uri: uri(one), name: path.basename(one) })),
    });
    await this.notify("initialized", {});
    return result;
  }

  request<T>(method: string, params?: unknown): Promise<T> {
    return within(this.connection.sendRequest<T>(method, params), method);
  }

  notify(method: string, params?: unknown): Promise<void> {
    return this.connection.sendNotification(method, params);
  }

  /** Opens a file, or the text that stands for it. */
  async open(file: string, text = readFileSync(file, "utf8"), languageId = "glsl"): Promise<void> {
    this.documents.set(file, TextDocument.create(uri(file), languageId, 1, text));
    await this.notify("textDocument/didOpen", { textDocument: { uri: uri(file), languageId, version: 1, text } });
  }

  /** Replaces ranges of an open document, one after the other. */
  async edit(file: string, ...changes: { range: Range; text: string }[]): Promise<void> {
    const document = this.document(file);
    const version = document.version + 1;
    TextDocument.update(document, changes, version);
    const params = { textDocument: { uri: uri(file), version }, contentChanges: changes };
    await this.notify("textDocument/didChange", params);
  }

  /** Replaces the first `old` of an open document. */
  replace(file: string, old: string, text: string): Promise<void> {
    return this.edit(file, { range: this.range(file, old), text });
  }

  async close(file: string): Promise<void> {
    this.documents.delete(file);
    await this.notify("textDocument/didClose", { textDocument: { uri: uri(file) } });
  }

  document(file: string): TextDocument {
    const document = this.documents.get(file);
    assert(document !== undefined, `${file} is not open`);
    return document;
  }

  text(file: string): string {
    return this.document(file).getText();
  }

  /** The range of the first `part` of a document, in UTF-16. */
  range(file: string, part: string): Range {
    const document = this.document(file);
    const start = document.getText().indexOf(part);
    assert(start >= 0, `${file} has no ${part}`);
    return { start: document.positionAt(start), end: document.positionAt(start + part.length) };
  }

  /** Parameters of a request about the first `part` of a document. */
  at(file: string, part: string): { textDocument: { uri: string }; position: Position } {
    return { textDocument: { uri: uri(file) }, position: this.range(file, part).start };
  }

  async hints(file: string): Promise<InlayHint[]> {
    const whole = { start: { line: 0, character: 0 }, end: { line: 1_000_000, character: 0 } };
    const found = await this.request<InlayHint[] | null>("textDocument/inlayHint", {
      textDocument: { uri: uri(file) },
      range: whole,
    });
    return found ?? [];
  }

  /** The labels of the hints in the line of the first `part`. */
  async labels(file: string, part: string): Promise<string[]> {
    const { line } = this.range(file, part).start;
    return (await this.hints(file)).filter((one) => one.position.line === line).map((one) => labelOf(one));
  }

  /** Waits until something holds, looking after each message. */
  async until<T>(what: string, look: () => T | undefined | false): Promise<T> {
    const found = new Promise<T>((resolve) => {
      const again = () => {
        const value = look();
        if (value !== undefined && value !== false) {
          this.waiting.delete(again);
          resolve(value);
        }
      };
      this.waiting.add(again);
      again();
    });
    return within(found, what);
  }

  /** The codes of the last findings of a file. */
  codes(file: string): string[] {
    return (this.findings.get(uri(file))?.diagnostics ?? []).map((one) => String(one.code));
  }

  /** Waits for a finding. */
  finding(file: string, code: string): Promise<Diagnostic> {
    return this.until(`${code} in ${path.basename(file)}`, () => {
      return this.findings.get(uri(file))?.diagnostics.find((one) => one.code === code);
    });
  }

  /** Waits until a file has no finding of a code. */
  async withoutFinding(file: string, code: string): Promise<void> {
    await this.until(`no ${code} in ${path.basename(file)}`, () => !this.codes(file).includes(code));
  }

  /** Runs something, and waits for a notification or request of the server that follows. */
  async followed<T>(method: string, run: () => Promise<T>): Promise<unknown> {
    const before = this.asked.length;
    await run();
    return this.until(method, () => this.asked.slice(before).find((one) => one.method === method));
  }

  /** The code actions for a range. */
  actions(file: string, range: Range, only?: string[]): Promise<CodeAction[]> {
    const overlaps = (one: Diagnostic) =>
      one.range.start.line <= range.end.line && range.start.line <= one.range.end.line;
    const diagnostics = (this.findings.get(uri(file))?.diagnostics ?? []).filter(overlaps);
    const context = only === undefined ? { diagnostics } : { diagnostics, only };
    return this.request("textDocument/codeAction", { textDocument: { uri: uri(file) }, range, context });
  }

  /** The texts of files with an edit applied, open ones as they are open. */
  applied(edit: WorkspaceEdit): Map<string, string> {
    const texts = new Map<string, string>();
    const apply = (target: string, edits: TextEdit[]) => {
      const open = [...this.documents.values()].find((one) => one.uri === target);
      const document = open ?? TextDocument.create(target, "", 0, readFileSync(new URL(target), "utf8"));
      texts.set(target, TextDocument.applyEdits(document, edits));
    };
    for (const [target, edits] of Object.entries(edit.changes ?? {})) {
      apply(target, edits);
    }
    for (const change of edit.documentChanges ?? []) {
      assert("edits" in change, "only texts are changed");
      const open = [...this.documents.values()].find((one) => one.uri === change.textDocument.uri);
      assert.equal(change.textDocument.version, open?.version ?? null, "the version that the client has");
      apply(change.textDocument.uri, change.edits as TextEdit[]);
    }
    return texts;
  }

  /** Ends the server as the protocol has it. */
  async end(): Promise<void> {
    assert.equal(await this.request("shutdown"), null);
    await this.notify("exit");
    assert.equal(await within(this.exited, "exit"), 0);
    assert(!this.stderr.includes("panicked"), this.stderr);
  }
}

export function uri(file: string): string {
  return pathToFileURL(file).href;
}

export function labelOf(hint: InlayHint): string {
  return typeof hint.label === "string" ? hint.label : hint.label.map((part) => part.value).join("");
}

export async function within<T>(wanted: Promise<T>, what: string): Promise<T> {
  let timer: NodeJS.Timeout | undefined;
  const late = new Promise<never>((_, reject) => {
    timer = setTimeout(() => reject(new Error(`${what} does not come`)), patience);
  });
  return Promise.race([wanted, late]).finally(() => clearTimeout(timer));
}

/** Whether an error has one of the codes of JSON-RPC or of the protocol. */
export function withCode(...codes: number[]): (cause: unknown) => boolean {
  return (cause) => codes.includes((cause as { code: number }).code);
}

/**
 * Runs an editor with the lines that the book gives it in a language, and what is typed, on a shader that
 * is locked. Returns the object that it prints.
 */
export function editorSession(
  language: string,
  names: { init: string; typed: string },
  typed: string,
  start: (place: string) => { command: string; args: string[]; env: NodeJS.ProcessEnv },
): Record<string, string> {
  const root = path.join(__dirname, "../../..");
  const page = readFileSync(path.join(root, "docs/src/editors.md"), "utf8");
  const config = page.match(new RegExp("```" + language + "\\n([^]*?)```"))?.[1];
  assert(config !== undefined);
  const shader = readFileSync(path.join(root, "shaders/light_arrays/point_lights_450.frag"), "utf8");
  const place = folder({ [names.init]: config, [names.typed]: typed, "work/point_lights_450.frag": shader });
  const [work, bin] = [path.join(place, "work"), path.join(place, "bin")];
  write(path.join(work, "landfall.toml"), "");
  mkdirSync(bin);
  symlinkSync(program, path.join(bin, "landfall"));
  execFileSync(program, ["lock", "--quiet"], { cwd: work });
  const { command, args, env } = start(place);
  const printed = execFileSync(command, args, {
    cwd: work,
    encoding: "utf8",
    stdio: ["ignore", "pipe", "pipe"],
    env: { ...process.env, PATH: `${bin}:${process.env.PATH ?? ""}`, ...env },
  });
  return JSON.parse(printed) as Record<string, string>;
}
