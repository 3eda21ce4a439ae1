// The extension: `landfall lsp` as the server of shaders, and commands that ask it.

import * as vscode from "vscode";
import { Server } from "./client";
import { registerCommands } from "./commands";
import { codeAt } from "./rules";

let server: Server | undefined;

export function activate(context: vscode.ExtensionContext): void {
  const started = new Server();
  server = started;
  context.subscriptions.push(started.log, ...registerCommands(started));
  const changed = vscode.workspace.onDidChangeConfiguration((event) => {
    if (event.affectsConfiguration("landfall.server.path")) {
      void vscode.commands.executeCommand("landfall.restartServer");
    }
  });
  const pages = vscode.window.registerUriHandler({
    handleUri: (uri) => {
      const code = codeAt(uri.path);
      return code === undefined ? undefined : void vscode.commands.executeCommand("landfall.explainRule", code);
    },
  });
  context.subscriptions.push(changed, pages);
  // A message about a server that is missing waits for its reader.
  void started.start();
}

export async function deactivate(): Promise<void> {
  await server?.stop();
}
