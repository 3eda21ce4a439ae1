// How results of commands are shown that the server has written to a file.

import * as vscode from "vscode";
import type { ShowDocumentRequest } from "vscode-languageclient/node";

let hidden = 0;

/** Runs something whose result is wanted, but not shown. */
export async function withoutShowing<T>(run: () => Promise<T>): Promise<T> {
  hidden += 1;
  try {
    return await run();
  } finally {
    hidden -= 1;
  }
}

/** Shows pages of HTML in a tab, also where the browser is on another machine, and Markdown as it reads. */
export const showDocument: ShowDocumentRequest.MiddlewareSignature = async (params, token, next) => {
  if (hidden > 0) {
    return { success: true };
  }
  const uri = vscode.Uri.parse(params.uri);
  if (uri.path.endsWith(".html")) {
    await showPage(uri);
    return { success: true };
  }
  if (uri.path.endsWith(".md")) {
    await vscode.commands.executeCommand("markdown.showPreview", uri);
    return { success: true };
  }
  return next(params, token);
};

async function showPage(uri: vscode.Uri): Promise<void> {
  const bytes = await vscode.workspace.fs.readFile(uri);
  const panel = vscode.window.createWebviewPanel("landfall.page", "Memory Maps", vscode.ViewColumn.Beside, {
    enableScripts: true,
    enableFindWidget: true,
    localResourceRoots: [],
  });
  panel.webview.html = new TextDecoder().decode(bytes);
}
