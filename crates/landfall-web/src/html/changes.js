// A difference: the old and the new map of a block, and what moved drawn between them.

const SVG = 'http://www.w3.org/2000/svg';

/** A changed block. */
class ChangeView {
  constructor(change, shader, detail) {
    Object.assign(this, { change, shader, detail, drawn: false });
    this.state = { colours: new Map(), opened: new Map() };
    this.id = nextId('change-');
    this.old = change.old?.layouts[0];
    this.new = change.new?.layouts[0];
    this.renames = this.renamed();
    this.element = this.article();
    this.element.view = this;
  }

  get title() {
    return this.change.name;
  }

  /** New patterns by old ones. */
  renamed() {
    const found = [];
    for (const { kind, path, new: now } of this.change.list) {
      if (kind === 'renamed') found.push([path, now]);
    }
    return found;
  }

  /** The path on the new side of a concrete path of the old side. */
  now(path) {
    const bare = pattern(path).replaceAll('[]', '');
    for (const [was, is] of this.renames) {
      const old = was.replaceAll('[]', '');
      if (bare !== old && !bare.startsWith(`${old}.`)) continue;
      // Indices stay where they are: names are replaced one by one.
      const names = is.replaceAll('[]', '').split('.');
      return path.split('.').map((part, index) => (
        index < names.length ? names[index] + part.slice(part.replace(/\[.*$/, '').length) : part
      )).join('.');
    }
    return path;
  }

  article() {
    const { change } = this;
    const list = change.list.map((line) => el('li', {}, el('span', { class: `badge ${line.class}` }, line.class), ' ',
      prose(line.message), line.verdict ? el('span', { class: 'note' }, ` (${line.verdict})`) : null));
    this.pair = el('div', { class: 'pair' });
    return el('article', { class: 'block change', 'aria-labelledby': this.id },
      el('h3', { id: this.id, tabindex: '-1' }, `${this.title} `, el('span', { class: `badge ${change.class}` }, change.class)),
      el('ul', { class: 'changes' }, list), this.pair);
  }

  draw() {
    this.drawn = true;
    const to = this.placesOf(this.new);
    const from = new Map();
    this.moves = [];
    const was = this.figure('Old', this.change.old, this.old, (place) => {
      const path = this.now(place.path);
      const there = to.get(path);
      from.set(path, place);
      if (!there) return this.new && { class: 'gone', text: 'removed', short: 'removed' };
      if (there.start === place.start && path === place.path) return null;
      if (there.start !== place.start) this.moves.push([place.path, path]);
      return there.start === place.start ? { class: 'moved', text: `is now ${last(there)}`, short: `→ ${last(there)}` }
        : { class: 'moved', text: `moves to ${there.start}`, short: `→ ${there.start}` };
    });
    const is = this.figure('New', this.change.new, this.new, (place) => {
      const before = from.get(place.path);
      if (!before) return this.old && { class: 'added', text: 'new', short: 'new' };
      this.state.colours.set(colourKey(place), this.state.colours.get(colourKey(before)));
      if (before.start === place.start && before.path === place.path) return null;
      return before.start === place.start ? { class: 'moved', text: `was ${last(before)}`, short: `← ${last(before)}` }
        : { class: 'moved', text: `was at ${before.start}`, short: `← ${before.start}` };
    });
    this.lines = document.createElementNS(SVG, 'svg');
    this.lines.setAttribute('class', 'lines');
    this.lines.setAttribute('aria-hidden', 'true');
    this.pair.replaceChildren(was, is, this.lines);
    this.connect();
    this.watch ??= new ResizeObserver(() => this.connect());
    this.watch.observe(this.pair);
  }

  /** The places that the map of a layout shows, by path. */
  placesOf(layout) {
    const found = new Map();
    if (!layout) return found;
    const state = { colours: new Map(), opened: this.state.opened };
    const map = memoryMap(layout, { state, label: '' });
    map.items.forEach(({ place }) => {
      if (place && place.kind === 'vector' && !place.byRow) found.set(place.path, place);
    });
    return found;
  }

  figure(side, block, layout, mark) {
    const caption = el('p', { class: 'caption' });
    if (!layout || layout.size === null) {
      caption.append(layout ? `${side}: loose uniforms, without bytes` : `${side}: no such block`);
      return el('div', { class: 'figure' }, caption);
    }
    caption.append(`${side} · ${RULE_NAMES[layout.rules]} · ${sizeText(layout)}`);
    const map = memoryMap(layout, {
      state: this.state, label: `${side} map of ${this.title}; arrow keys move between cells`,
      changed: (byte) => {
        this.draw();
        const cells = [...this.pair.querySelectorAll(`[data-side=${side.toLowerCase()}] .cell`)];
        cells.find(({ place }) => byte >= place.start && byte < place.end)?.focus();
      },
      mark: (place) => (place.byRow ? null : mark(place)),
    });
    for (const event of ['mouseover', 'focusin', 'click']) {
      map.addEventListener(event, ({ target }) => {
        const { place } = target.closest('.cell, .head') ?? {};
        if (place) this.detail.show(place, layout, this.shader, null);
      });
    }
    const details = el('details', {}, el('summary', {}, `${side} table of ${this.title}`));
    details.fill = () => {
      details.fill = null;
      details.append(mapTable(map.items, `${side} members and padding of ${this.title}`, false));
    };
    details.addEventListener('toggle', () => details.open && details.fill?.());
    return el('div', { class: 'figure', data: { side: side.toLowerCase() } }, caption, map, details);
  }

  /** Draws a band from each cell that moved to where it is now, if the maps are side by side. */
  connect() {
    const [old, now] = this.pair.querySelectorAll('.figure');
    const box = this.pair.getBoundingClientRect();
    this.lines.replaceChildren();
    this.lines.setAttribute('width', box.width);
    this.lines.setAttribute('height', box.height);
    if (!old || !now || now.getBoundingClientRect().left < old.getBoundingClientRect().right - 1) return;
    const cells = (figure) => new Map([...figure.querySelectorAll('button.cell[data-path]')].map((cell) => [cell.dataset.path, cell]));
    const [from, to] = [cells(old), cells(now)];
    for (const [was, is] of this.moves) {
      const [a, b] = [from.get(was)?.getBoundingClientRect(), to.get(is)?.getBoundingClientRect()];
      if (!a || !b) continue;
      // Along the lower edges of the cells, so that no text is crossed.
      const [from1, to1] = [a.left - box.left, old.getBoundingClientRect().right - box.left];
      const [from2, to2] = [now.getBoundingClientRect().left - box.left, b.right - box.left];
      const [y1, y2] = [a.bottom - box.top, b.bottom - box.top];
      const middle = (to1 + from2) / 2;
      const path = document.createElementNS(SVG, 'path');
      path.setAttribute('d', `M${from1},${y1} H${to1} C${middle},${y1} ${middle},${y2} ${from2},${y2} H${to2}`);
      path.setAttribute('class', 'line');
      this.lines.append(path);
    }
  }
}
