// The editor of the playground: CodeMirror with the words of GLSL and WGSL, bundled by `build` into
// the script that the page holds. The page uses `Editor` and nothing else of CodeMirror.

import { defaultKeymap, history, historyKeymap, indentWithTab } from '@codemirror/commands';
import {
  bracketMatching, HighlightStyle, indentUnit, StreamLanguage, syntaxHighlighting,
} from '@codemirror/language';
import { Compartment, EditorState, StateEffect, StateField } from '@codemirror/state';
import {
  Decoration, drawSelection, EditorView, highlightActiveLine, highlightSpecialChars, hoverTooltip,
  keymap, lineNumbers,
} from '@codemirror/view';
import { tags } from '@lezer/highlight';

const KEYWORDS = new Set((
  'alias attribute break buffer case centroid coherent const const_assert continue continuing default discard do '
  + 'else enable false fallthrough flat fn for highp if in inout invariant layout let loop lowp mediump '
  + 'noperspective out override patch precise precision private push_constant read readonly requires '
  + 'restrict return sample shared smooth storage struct subroutine switch true uniform var varying void '
  + 'volatile while workgroup writeonly'
).split(' '));

const TYPES = new RegExp('^(?:bool|int|uint|float|double|half|[iu]?(?:8|16|32|64)|[iuf](?:16|32)|'
  + '[biud]?vec[234][fiuh]?|d?mat[234](?:x[234])?[fh]?|array|atomic|ptr|'
  + '(?:[iu]?(?:sampler|image|texture|subpassInput)\\w*)|texture_\\w+|sampler(?:_comparison)?)$');

/** Tokens of both languages: comments, numbers, words, directives and attributes. */
const words = StreamLanguage.define({
  name: 'shader',
  startState: () => ({ comment: 0 }),
  token(stream, state) {
    if (state.comment > 0) {
      while (!stream.eol()) {
        if (stream.match('*/')) {
          state.comment -= 1;
          if (state.comment === 0) break;
        } else stream.next();
      }
      return 'comment';
    }
    if (stream.eatSpace()) return null;
    if (stream.match('//')) {
      stream.skipToEnd();
      return 'comment';
    }
    if (stream.match('/*')) {
      state.comment = 1;
      return 'comment';
    }
    if (stream.sol() && stream.match(/#\s*\w*/) || stream.match(/@\w+/)) return 'meta';
    if (stream.match(/(?:0x[\da-f]+[iu]?|(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?[fhiulf]*)/i)) return 'number';
    const word = stream.match(/\w+/);
    if (word) {
      if (KEYWORDS.has(word[0])) return 'keyword';
      return TYPES.test(word[0]) ? 'typeName' : null;
    }
    stream.next();
    return null;
  },
  languageData: { commentTokens: { line: '//', block: { open: '/*', close: '*/' } } },
});

const colours = HighlightStyle.define([
  { tag: tags.comment, color: 'var(--muted)', fontStyle: 'italic' },
  { tag: tags.keyword, color: 'var(--keyword)' },
  { tag: tags.typeName, color: 'var(--accent)' },
  { tag: tags.number, color: 'var(--good)' },
  { tag: tags.meta, color: 'var(--warning)' },
]);

const theme = EditorView.theme({
  '&': { height: '100%', color: 'var(--text)', backgroundColor: 'var(--ground)', fontSize: '13px' },
  '&.cm-focused': { outline: '3px solid var(--accent)', outlineOffset: '-3px' },
  '.cm-scroller': { fontFamily: 'var(--mono)', lineHeight: '1.5' },
  '.cm-gutters': { color: 'var(--muted)', backgroundColor: 'var(--panel)', borderRight: '1px solid var(--line)' },
  '.cm-activeLine, .cm-activeLineGutter': { backgroundColor: 'transparent' },
  '.cm-content': { caretColor: 'var(--text)' },
  '.cm-cursor': { borderLeftColor: 'var(--text)' },
  '&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground': {
    backgroundColor: 'var(--selection)',
  },
  '&.cm-focused .cm-matchingBracket': { backgroundColor: 'var(--selection)' },
  '.mark-error': { textDecoration: 'underline wavy var(--error) 1.5px', textUnderlineOffset: '3px' },
  '.mark-warning': { textDecoration: 'underline wavy var(--warning) 1.5px', textUnderlineOffset: '3px' },
  '.mark-here': { backgroundColor: 'var(--selection)' },
  '.cm-tooltip': {
    color: 'var(--text)', backgroundColor: 'var(--panel)', border: '1px solid var(--muted)',
    padding: '0.3rem 0.6rem', maxWidth: '32rem', whiteSpace: 'pre-wrap',
  },
});

const setMarks = StateEffect.define();

/** The marks of findings: `{ from, to, level, text }`. */
const marks = StateField.define({
  create: () => ({ list: [], shown: Decoration.none }),
  update(value, transaction) {
    let { list, shown } = value;
    if (transaction.docChanged) shown = shown.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (!effect.is(setMarks)) continue;
      list = effect.value;
      const { length } = transaction.newDoc;
      shown = Decoration.set(list.filter(({ from, to }) => from < to && to <= length).map((mark) => (
        Decoration.mark({ class: `mark-${mark.level}`, mark }).range(mark.from, mark.to)
      )), true);
    }
    return { list, shown };
  },
  provide: (field) => EditorView.decorations.from(field, ({ shown }) => shown),
});

/** What is said of a marked text under the pointer. */
const told = hoverTooltip((view, at) => {
  const found = [];
  let end = at;
  view.state.field(marks).shown.between(at, at, (from, to, { spec }) => {
    if (spec.mark.text) found.push(spec.mark.text);
    end = Math.max(end, to);
  });
  if (found.length === 0) return null;
  return {
    pos: at, end, above: true,
    create() {
      const dom = document.createElement('div');
      dom.textContent = found.join('\n\n');
      return { dom };
    },
  };
});

/** An editor in a shadow tree of `host`, so that its style sheets need no permission of the page's policy. */
export function create(host, text, changed) {
  const root = host.attachShadow({ mode: 'open' });
  const wrapping = new Compartment();
  const view = new EditorView({
    root,
    parent: root,
    state: EditorState.create({
      doc: text,
      extensions: [
        lineNumbers(), history(), drawSelection(), bracketMatching(), highlightSpecialChars(), highlightActiveLine(),
        indentUnit.of('    '), EditorState.tabSize.of(4), words, syntaxHighlighting(colours), theme, marks, told,
        wrapping.of([]),
        EditorView.contentAttributes.of({ 'aria-label': 'Shader', spellcheck: 'false', tabindex: '0' }),
        // Escape, then Tab leaves the editor.
        keymap.of([...defaultKeymap, ...historyKeymap, indentWithTab]),
        EditorView.updateListener.of((update) => update.docChanged && changed(update.state.doc.toString())),
      ],
    }),
  });
  return {
    view,
    get text() { return view.state.doc.toString(); },
    set text(given) { view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: given } }); },
    /** Whether lines that are longer than the editor is wide go on below. */
    set wraps(does) { view.dispatch({ effects: wrapping.reconfigure(does ? EditorView.lineWrapping : []) }); },
    mark(list) { view.dispatch({ effects: setMarks.of(list) }); },
    /** Moves the cursor to a line and its column, both from 1. */
    goTo(number, column) {
      const line = view.state.doc.line(Math.min(Math.max(number, 1), view.state.doc.lines));
      const at = Math.min(line.from + Math.max(column - 1, 0), line.to);
      view.dispatch({ selection: { anchor: at }, effects: EditorView.scrollIntoView(at, { y: 'center' }) });
      view.focus();
    },
    focus() { view.focus(); },
  };
}
