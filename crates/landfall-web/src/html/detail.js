// The panel of the selected bytes, findings, and files that are dropped on blocks.

/** The panel that says what is under the pointer or has the focus. */
class Detail {
  constructor(element) {
    this.element = element;
    element.classList.add('empty');
    element.append(el('h2', {}, 'Bytes'), el('p', {}, 'Point at a cell, or move to it with the arrow keys: '
      + 'here is its path, its offset and the rules that put it there.'));
  }

  show(place, layout, shader, view) {
    if (this.place === place && this.view === view) return;
    Object.assign(this, { place, view });
    this.element.classList.remove('empty');
    const padding = place.kind === 'padding';
    const size = place.end - place.start;
    const facts = [
      ['Offset', `${place.start} (${hex(place.start)})`],
      ['Bytes', size > 0 ? `${place.start} to ${place.end - 1}, ${bytes(size)}` : 'none'],
      ['Type', padding ? null : typeOf(place)],
      ['Align', padding || place.vector !== null && place.vector !== undefined ? null : place.member.align],
      ['Rules', RULE_NAMES[layout.rules]],
      ['Declared', place.member?.line > 0 ? `${shader.path}:${place.member.line}` : null],
    ];
    if (view && place.kind === 'vector') {
      const values = components(view, place);
      facts.push(['Value', values.map(told).join(', ')]);
    }
    const list = el('dl', {}, facts.filter(([, value]) => value !== null && value !== '')
      .map(([name, value]) => [el('dt', {}, name), el('dd', {}, String(value))]));
    const title = padding ? place.padding : place.path;
    this.element.replaceChildren(el('h2', {}, padding ? title : el('code', {}, title)), list);
    if (padding) this.element.append(el('p', {}, prose(paddingText(place))));
    else this.element.append(el('h3', {}, 'Why here'), el('ol', { class: 'chain' }, chain(place).map(step)));
  }
}

/** A step of the chain of rules. */
function step({ path, type, rule, lines, base, adds }) {
  return el('li', {}, el('p', {}, el('code', {}, path), ' ', el('span', { class: 'type' }, type)),
    rule.map((line) => el('p', { class: 'rule' }, line)), lines.map((line) => el('p', {}, prose(line))),
    el('p', { class: 'sum' }, `${base} + ${adds} = ${base + adds}`));
}

/** What a level of the configuration is called in messages. */
const levelOf = ({ level }) => (level === 'deny' ? 'error' : 'warning');

/** Badges with the number of errors and of warnings. */
function badges(findings) {
  return ['error', 'warning'].flatMap((level) => {
    const count = findings.filter((one) => levelOf(one) === level).length;
    return count > 0 ? [' ', el('span', { class: `badge ${level}` }, counted(count, level))] : [];
  });
}

/** Where a finding is, as messages print it. */
const whereIs = ({ place }) => (place.line > 0 ? `${place.path}:${place.line}:${place.column}` : place.path);

/** The lines that a finding is about, with their numbers, as the terminal prints them. */
function excerpt({ place, text: remark, related, lines = [] }) {
  const labels = [{ place, text: remark, sign: '^' }, ...related.map((one) => ({ ...one, sign: '-' }))];
  const isOther = (label) => label.place.path !== place.path;
  const shown = labels.map((label, index) => ({ ...label, lines: lines[index] ?? [] })).filter((one) => one.lines.length > 0)
    .sort((a, b) => isOther(a) - isOther(b) || a.place.line - b.place.line);
  if (shown.length === 0) return null;
  const indents = shown.flatMap((one) => one.lines).filter((line) => line.trim() !== '').map((line) => line.length - line.trimStart().length);
  const indent = Math.min(...indents, Infinity);
  const width = Math.max(...shown.map((one) => String(one.place.line + one.lines.length - 1).length));
  const out = [];
  const add = (number, line, name = '') => out.push(el('span', { class: 'gutter' }, `${String(number).padStart(width)} │ `), name ? el('b', { class: name }, line) : line, '\n');
  shown.forEach(({ place: at, text: told, sign, lines: all }, index) => {
    const before = shown[index - 1]?.place;
    if (at.path !== (before?.path ?? place.path)) add('', at.path);
    all.forEach((line, nth) => {
      const letters = [...line];
      const last = nth === at.end_line - at.line;
      const from = nth === 0 ? at.column - 1 : letters.length - [...line.trimStart()].length;
      const to = last ? Math.max(at.end_column - 1, from + 1) : letters.length;
      // Several places of one line stand below it once.
      if (index === 0 || nth > 0 || before.line !== at.line || before.path !== at.path) add(at.line + nth, line.slice(indent).replaceAll('\t', ' '));
      const end = nth === all.length - 1 && told ? ` ${told}` : '';
      add('', `${' '.repeat(Math.max(0, from - indent))}${sign.repeat(Math.max(1, to - from))}${end}`, sign === '^' ? 'here' : 'there');
    });
  });
  return el('pre', { class: 'excerpt', tabindex: '0', role: 'region', 'aria-label': `Lines of ${whereIs({ place })}` }, out);
}

/** A finding with the lines that it is about, its notes, listing and help. */
function findingItem(finding) {
  const level = levelOf(finding);
  const lines = excerpt(finding);
  const named = (label) => el('p', { class: 'note' }, `${label.place.path}:${label.place.line}`, label.text ? [': ', prose(label.text)] : '');
  const isUnseen = (index) => !lines || !finding.lines?.[index]?.length;
  return el('li', { class: `finding ${level}`, tabindex: '-1' },
    el('p', {}, el('span', { class: `badge ${level}` }, level), ' ', el('code', {}, finding.code), ' ', prose(finding.message)),
    el('p', { class: 'note' }, whereIs(finding), finding.text && isUnseen(0) ? [': ', prose(finding.text)] : ''),
    lines,
    finding.related.map((label, index) => (isUnseen(index + 1) ? named(label) : null)),
    finding.notes.map((note) => el('p', { class: 'note' }, prose(note))),
    finding.listing ? el('pre', { tabindex: '0' }, finding.listing) : null,
    finding.help ? el('p', {}, el('b', {}, 'help: '), prose(finding.help)) : null);
}

/** A file dropped on a block is its bytes; anywhere else it is ignored, not opened. */
function dropping() {
  const over = (target) => target.closest?.('article.block')?.view;
  document.addEventListener('dragover', (event) => event.preventDefault());
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    const view = over(event.target);
    if (view?.read && event.dataTransfer.files.length > 0) view.read(event.dataTransfer.files[0]);
  });
}
