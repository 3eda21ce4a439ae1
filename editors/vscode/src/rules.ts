// The pages about lints: addresses that this extension answers itself.

/** The identifier of this extension, which its addresses have for a host. */
const extension = "landfall.landfall";

/** The address of the pages in an editor of this scheme, as the server takes it. */
export function pagesAt(scheme: string): string {
  return `${scheme}://${extension}/rule/{code}`;
}

/** The code whose page an address of this extension names. */
export function codeAt(path: string): string | undefined {
  return /^\/rule\/([a-z0-9-]+)$/.exec(path)?.[1];
}

/** Settings for the server; where they name no pages, those of this extension are. */
export function withPages(settings: unknown, pages: string): unknown {
  const given = { ...(settings as Record<string, unknown> | null) };
  return { ...given, rulePages: given.rulePages ?? pages };
}
