// The words of printed code in the colours of the editor.

/** A longer text stays in one colour: each word is an element. */
const MAX_COLOURED = 200_000;

const SLASHES = String.raw`\/\/.*|\/\*[^]*?\*\/`;
const QUOTED = String.raw`"(?:[^"\\\n]|\\.)*"`;
const LETTER = String.raw`'(?:[^'\\\n]|\\.[^'\n]*)'`;
const DIRECTIVE = String.raw`^[ \t]*#[ \t]*\w+`;
const NEVER = '(?!)';

/** The languages of printed code: regular expressions of comments, texts and annotations, and the keywords. */
const CODE = {
  rust: {
    comment: SLASHES, text: `${QUOTED}|${LETTER}`, meta: String.raw`#!?\[[^\]\n]*\]`,
    words: 'as const crate else enum extern false fn for if impl in let match mod move mut pub ref return self static struct super trait true type unsafe use where while',
  },
  c: {
    comment: SLASHES, text: `${QUOTED}|${LETTER}`, meta: DIRECTIVE,
    words: 'alignas _Alignas auto const constexpr else enum extern false for if inline namespace nullptr return sizeof static static_assert _Static_assert struct template true typedef union using while',
  },
  csharp: {
    comment: SLASHES, text: QUOTED, meta: String.raw`^[ \t]*\[[^\]\n]*\]|${DIRECTIVE}`,
    words: 'class const else false fixed for get if in internal namespace new null out private public readonly ref return set static struct this throw true unsafe using value',
  },
  python: {
    comment: '#.*', text: String.raw`"""[^]*?"""|${QUOTED}|'(?:[^'\\\n]|\\.)*'`, meta: String.raw`@\w+`,
    words: 'and as assert class def elif else except False for from if import in is lambda None not or pass raise return True try while with yield',
  },
  typescript: {
    comment: SLASHES, text: String.raw`${QUOTED}|'(?:[^'\\\n]|\\.)*'|\x60(?:[^\x60\\]|\\.)*\x60`, meta: NEVER,
    words: 'as class const else export extends false for from function get if import in interface let new null of return set static this throw true type typeof undefined while',
  },
  zig: {
    comment: SLASHES, text: `${QUOTED}|${LETTER}`, meta: String.raw`@\w+`,
    words: 'and break comptime const continue else enum error extern false fn for if inline null or orelse packed pub return struct switch true try type undefined union unreachable var while',
  },
  gdscript: {
    comment: '#.*', text: QUOTED, meta: String.raw`@\w+`,
    words: 'and assert class class_name const elif else enum extends false for func if in is not null or pass return self static true var while',
  },
  renderdoc: { comment: SLASHES, text: QUOTED, meta: `${DIRECTIVE}|\\[\\[[^\\]\\n]*\\]\\]`, words: 'enum row_major column_major struct unsigned' },
  listing: {
    comment: SLASHES, text: QUOTED, meta: String.raw`@\w+`,
    words: 'array buffer coherent column_major const highp layout lowp mediump readonly restrict row_major struct uniform var volatile writeonly',
  },
  json: { comment: NEVER, text: QUOTED, meta: NEVER, type: String.raw`${QUOTED}(?=\s*:)`, words: 'true false null' },
};

/** Names of types: those with capitals and small letters, and scalars, vectors and matrices. */
const A_TYPE = /^(?:[A-Z]\w*[a-z]\w*|[iu](?:8|16|32|64|size)|f(?:16|32|64)|(?:u?int|float)\d*(?:_t)?|s?byte|u?short|u?long|bool|char|double|half|number|size_t|str|void|[biud]?vec[234][fiuh]?|d?mat[234](?:x[234])?[fh]?)$/;

/** A text cut into words: each with its class, or `null` for what has the colour of the text. */
function tokens(text, language) {
  const code = CODE[language];
  if (!code || text.length > MAX_COLOURED) return [[null, text]];
  code.known ??= new Set(code.words.split(' '));
  const number = String.raw`\b\d[\d_]*(?:\.\d+)?(?:[eE][-+]?\d+)?\w*`;
  code.form ??= new RegExp(`(?<type>${code.type ?? NEVER})|(?<comment>${code.comment})|(?<text>${code.text})|(?<meta>${code.meta})|(?<number>${number})|(?<word>[A-Za-z_]\\w*)`, 'gm');
  const found = [];
  let from = 0;
  for (const { 0: all, index, groups } of text.matchAll(code.form)) {
    let [kind] = Object.entries(groups).find(([, part]) => part !== undefined);
    if (kind === 'word') kind = code.known.has(all) ? 'keyword' : A_TYPE.test(all) ? 'type' : null;
    if (kind === null) continue;
    if (index > from) found.push([null, text.slice(from, index)]);
    found.push([kind, all]);
    from = index + all.length;
  }
  if (from < text.length) found.push([null, text.slice(from)]);
  return found;
}

/** The elements of a text in a language. */
const coloured = (text, language) => tokens(text, language).map(([kind, part]) => {
  if (kind === null) return part;
  const word = document.createElement('span');
  word.className = `is-${kind}`;
  word.textContent = part;
  return word;
});
