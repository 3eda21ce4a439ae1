// What a cursor is in, from the symbols and the text of its document.

/** A place in a document, as the protocol and the editor have it. */
export interface Place {
  readonly line: number;
  readonly character: number;
}

/** A symbol of a document, as far as it matters here. */
export interface Named {
  readonly name: string;
  readonly range: { readonly start: Place; readonly end: Place };
}

/**
 * The block or structure that a cursor is in: in its lines, since a cursor before a name or behind the
 * last member is meant, too. The only one of a document is meant everywhere.
 */
export function blockAt<T extends Named>(symbols: readonly T[], cursor: Place): T | undefined {
  const inside = symbols.filter((one) => one.range.start.line <= cursor.line && cursor.line <= one.range.end.line);
  return inside.at(-1) ?? (symbols.length === 1 ? symbols[0] : undefined);
}

const glslFunction = /\b[A-Za-z_]\w*(?:\s*\[\s*\d*\s*\])?\s+([A-Za-z_]\w*)\s*\([^(){};]*\)\s*\{/g;
const wgslFunction = /\bfn\s+([A-Za-z_]\w*)\s*\(/g;

/** The function whose head is the last before a cursor, given as a number of characters of the text. */
export function functionAt(text: string, cursor: number): string | undefined {
  const plain = text.replace(/\/\/[^\n]*|\/\*[^]*?\*\//g, (comment) => " ".repeat(comment.length));
  const pattern = /\bfn\s/.test(plain) ? wgslFunction : glslFunction;
  const heads = [...plain.matchAll(pattern)].filter(([head]) => !/^(?:else|return)\s/.test(head));
  return heads.filter((head) => head.index <= cursor).at(-1)?.[1] ?? heads.at(0)?.[1];
}

/** The names that a text asks about: macros in `#if` and its kin, and features in `@if` and `@elif`. */
export function conditionNames(text: string): { macros: string[]; features: string[] } {
  const conditions = (pattern: RegExp) => {
    const words = [...text.matchAll(pattern)].flatMap((found) => found[1]?.match(/[A-Za-z_]\w*/g) ?? []);
    const names = words.filter((word) => !/^(?:defined|true|false|GL_\w+|__\w+)$/.test(word));
    return [...new Set(names)].sort();
  };
  return {
    macros: conditions(/^[ \t]*#[ \t]*(?:if|ifdef|ifndef|elif)\b([^\n]*)/gm),
    features: conditions(/@(?:if|elif)\s*\(([^\n]*)\)/g),
  };
}
