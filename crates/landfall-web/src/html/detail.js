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

/** A finding with its notes, listing and help. */
function findingItem(finding) {
  const { place } = finding;
  const where = place.line > 0 ? `${place.path}:${place.line}:${place.column}` : place.path;
  const level = finding.level === 'deny' ? 'error' : 'warning';
  return el('li', { class: 'finding' },
    el('p', {}, el('span', { class: `badge ${level}` }, level), ' ', el('code', {}, finding.code), ' ', prose(finding.message)),
    el('p', { class: 'note' }, where, finding.text ? [': ', prose(finding.text)] : ''),
    finding.related.map((label) => el('p', { class: 'note' }, `${label.place.path}:${label.place.line}`, label.text ? [': ', prose(label.text)] : '')),
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
