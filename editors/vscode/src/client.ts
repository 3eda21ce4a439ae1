// The server's life: found, started, ended and started again.

import * as vscode from "vscode";
import { type DocumentSelector, LanguageClient } from "vscode-languageclient/node";
import { findProgram, refusal } from "./executable";
import { showDocument } from "./results";
import { pagesAt, withPages } from "./rules";

const install = "cargo install landfall --features lsp";

/** Shaders by language, where an extension or this one names it, and by the files that only Landfall reads so. */
export const shaders: DocumentSelector = [
  ...["glsl", "wgsl", "wesl"].map((language) => ({ scheme: "file", language })),
  { scheme: "file", pattern: "**/*.{glsl,vert,frag,comp,geom,tesc,tese,mesh,task,rgen,rint,rahit,rchit,rmiss,rcall}" },
  { scheme: "file", pattern: "**/*.{vsh,fsh,glslinc,glslh,wgsl,wesl}" },
  // Elsewhere these are other languages: F#, C#, Visual Basic.
  { scheme: "file", language: "plaintext", pattern: "**/*.{vs,fs,ps,cs,gs}" },
];

const documents: DocumentSelector = [
  ...shaders,
  ...["rust", "c", "cpp"].map((language) => ({ scheme: "file", language })),
  { scheme: "file", pattern: "**/{landfall,.landfall}.toml" },
];

const pages = () => pagesAt(vscode.env.uriScheme);

export class Server {
  readonly log = vscode.window.createOutputChannel("Landfall", { log: true });
  private client: LanguageClient | undefined;

  /** Starts the server; what keeps it from starting is shown. */
  async start(): Promise<void> {
    const given = vscode.workspace.getConfiguration("landfall").get("server.path", "landfall");
    const program = findProgram(given);
    if (program === undefined) {
      await this.complain(`\`${given}\` was not found. \`${install}\` installs it; with \`full\` instead of \
\`lsp\` it also runs shaders.`);
      return;
    }
    const why = await refusal(program);
    if (why !== undefined) {
      await this.complain(`\`${program} lsp\` does not serve: ${why}\n\`${install}\` installs one that does.`);
      return;
    }
    this.client = new LanguageClient(
      "landfall",
      "Landfall",
      { command: program, args: ["lsp"] },
      {
        documentSelector: documents,
        outputChannel: this.log,
        initializationOptions: () => withPages(vscode.workspace.getConfiguration("landfall"), pages()),
        synchronize: { configurationSection: "landfall" },
        middleware: {
          window: { showDocument },
          workspace: {
            configuration: async (params, token, next) => {
              const settings = await next(params, token);
              return Array.isArray(settings) ? settings.map((one) => withPages(one, pages())) : settings;
            },
          },
        },
      },
    );
    // What goes wrong from here on the client shows.
    await this.client.start().catch((cause: unknown) => this.log.error(String(cause)));
  }

  async stop(): Promise<void> {
    const client = this.client;
    this.client = undefined;
    // One that has ended by itself cannot be asked to.
    await client?.dispose().catch((cause: unknown) => this.log.warn(String(cause)));
  }

  /** The client of the running server; without one, how to get it is shown. */
  async running(): Promise<LanguageClient | undefined> {
    if (this.client?.isRunning() !== true) {
      await this.complain("The server does not run.");
      return undefined;
    }
    return this.client;
  }

  private async complain(message: string): Promise<void> {
    this.log.error(message);
    const [copy, settings, restart] = ["Copy the Command", "Open Settings", "Restart"] as const;
    const chosen = await vscode.window.showErrorMessage(`Landfall: ${message}`, copy, settings, restart);
    switch (chosen) {
      case copy:
        return vscode.env.clipboard.writeText(install);
      case settings:
        return vscode.commands.executeCommand("workbench.action.openSettings", "landfall.server.path");
      case restart:
        return vscode.commands.executeCommand("landfall.restartServer");
    }
  }
}
