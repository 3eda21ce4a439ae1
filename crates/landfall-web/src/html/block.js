// A block: its facts, the switches of rules, the byte field, dropped bytes, its maps and tables.

const RULE_NAMES = { std140: 'std140', std430: 'std430', scalar: 'scalar', wgsl: 'WGSL' };

/** Members that a filter names in a block. */
const MAX_HITS = 6;

/** The number of the next element that needs an id. */
let ids = 0;
const nextId = (prefix) => {
  ids += 1;
  return `${prefix}${ids}`;
};

/** The facts of a block's size in a few words. */
function sizeText({ size, padding }) {
  if (size === null) return 'no bytes';
  const share = size > 0 && padding > 0 ? `, ${Math.round((padding * 100) / size)} % padding` : '';
  return `${bytes(size)}${share}`;
}

/** How a layout differs from that under the block's own rules. */
function comparison(layout, own) {
  if (layout === own) return '';
  const places = (one) => {
    const found = [];
    const collect = (members, base, path) => members.forEach((member) => {
      const key = `${path}.${member.name}`;
      found.push(`${key} ${base + member.offset} ${(member.strides ?? []).join(' ')} ${member.matrix_stride ?? ''}`);
      if (member.members) collect(member.members, base + member.offset, key);
    });
    collect(one.members, 0, '');
    return found;
  };
  const there = new Set(places(own));
  const moved = places(layout).filter((place) => !there.has(place)).length;
  const size = layout.size - own.size;
  if (moved === 0 && size === 0) return `the same as ${RULE_NAMES[own.rules]}`;
  const parts = moved === 0 ? ['same offsets'] : [`${counted(moved, 'member')} elsewhere`];
  if (size !== 0) parts.push(`${Math.abs(size)} bytes ${size < 0 ? 'smaller' : 'larger'}`);
  return parts.join(', ');
}

/** A block of the page; its maps are drawn by `draw`, once it comes into view. */
class BlockView {
  constructor(block, shader, detail) {
    Object.assign(this, { block, shader, detail, view: null, drawn: false });
    this.own = block.layouts.find((layout) => layout.rules === block.rules) ?? block.layouts[0];
    this.rules = new Set([this.own.rules]);
    this.state = { colours: new Map(), opened: new Map() };
    this.id = nextId('block-');
    this.element = this.article();
    this.element.view = this;
  }

  /** Takes over what is chosen in the view of the same block before its text was changed. */
  adopt(other) {
    const rules = this.block.layouts.map((layout) => layout.rules).filter((one) => other.rules.has(one));
    if (other.rules.size > 1 && rules.length > 0) this.rules = new Set(rules);
    this.state = other.state;
    this.element.querySelectorAll('.rules button').forEach((button) => {
      button.setAttribute('aria-pressed', String(this.rules.has(button.dataset.rules)));
    });
    if (!other.dump || !this.offset) return;
    this.dump = other.dump;
    this.offset.value = other.offset.value;
    this.loaded.hidden = false;
    this.take();
  }

  get title() {
    const { name, instance, space } = this.block;
    return [space === 'default' ? 'Loose uniforms' : name, instance].filter(Boolean).join(' ');
  }

  article() {
    const { block } = this;
    const facts = [
      block.space, block.slot, block.buffers && counted(block.buffers, 'buffer'),
      block.rules && `${RULE_NAMES[block.rules]}${block.rules_declared ? '' : ' assumed'}`,
      sizeText(this.own), block.line > 0 && `line ${block.line}`, block.variant,
    ].filter(Boolean);
    this.maps = el('div', { class: 'maps' });
    this.output = el('output', { class: 'who', id: `${this.id}-who` });
    this.odd = el('div', { class: 'oddities', 'aria-live': 'polite' });
    this.hits = el('p', { class: 'note hits', hidden: true });
    const heading = el('h3', { id: this.id, tabindex: '-1' }, this.title);
    const article = el('article', { class: 'block', 'aria-labelledby': this.id },
      heading, el('p', { class: 'facts' }, facts.flatMap((fact, at) => [at > 0 ? ' · ' : '', el('span', { class: 'fact' }, fact)])), this.hits);
    if (block.opaque) article.append(el('p', { class: 'note' }, `Not in the buffer: ${block.opaque.join(', ')}`));
    if (this.own.size === null) {
      article.append(el('p', { class: 'note' }, `Loose uniforms have no bytes; ${document.body.classList.contains('playground') ? '“Gather loose uniforms”' : '--gather'} lays them out as a block.`), this.maps);
    } else article.append(this.tools(), this.output, this.odd, this.maps);
    article.style.containIntrinsicSize = `auto ${this.height()}px`;
    return article;
  }

  /** A guess of the height of what is not drawn yet, so that the scroll bar hardly moves. */
  height() {
    return 190 + 40 * Math.min(60, Math.ceil((this.own.size ?? 0) / ROW));
  }

  tools() {
    const { block } = this;
    const rules = el('div', { class: 'rules', role: 'group', 'aria-label': `Rules of ${this.title}` });
    for (const layout of block.layouts) {
      rules.append(el('button', {
        type: 'button', 'aria-pressed': String(this.rules.has(layout.rules)), data: { rules: layout.rules },
        on: { click: ({ currentTarget }) => this.toggle(layout.rules, currentTarget) },
      }, RULE_NAMES[layout.rules]));
    }
    const who = el('input', {
      type: 'text', inputmode: 'numeric', size: '7', autocomplete: 'off', spellcheck: 'false', class: 'byte',
      placeholder: '172', on: { input: () => this.find(who.value) },
    });
    this.offset = el('input', {
      type: 'text', inputmode: 'numeric', size: '5', autocomplete: 'off', value: '0', class: 'from',
      on: { input: () => this.take() },
    });
    const file = el('input', { type: 'file', on: { change: () => this.read(file.files[0]) } });
    const clear = el('button', { type: 'button', on: { click: () => this.forget(file) } }, 'Clear');
    this.loaded = el('span', { class: 'loaded', hidden: true }, el('label', {}, 'from byte ', this.offset), ' ', clear);
    return el('div', { class: 'tools' }, rules,
      el('label', {}, 'Who is at byte ', who),
      el('label', { class: 'file', title: 'The file that landfall decode reads; it can be dropped here, too' }, file, 'Show bytes…'),
      this.loaded);
  }

  toggle(rules, button) {
    if (this.rules.has(rules) && this.rules.size > 1) this.rules.delete(rules);
    else this.rules.add(rules);
    button.setAttribute('aria-pressed', String(this.rules.has(rules)));
    this.draw();
  }

  /** Draws the maps and their tables. */
  draw() {
    this.drawn = true;
    const shown = this.block.layouts.filter((layout) => this.rules.has(layout.rules));
    this.maps.classList.toggle('several', shown.length > 1);
    this.maps.replaceChildren(...shown.map((layout) => this.figure(layout, shown.length > 1)));
    if (this.view) this.report(shown);
    if (this.wanted) this.mark(this.wanted);
  }

  /** The names of the members, in lower case, by the paths that they have with open indices. */
  get members() {
    if (this.names) return this.names;
    this.names = [];
    const collect = (members, base) => members.forEach(({ name, dims, members: inner = [] }) => {
      const path = `${base}${name}${'[]'.repeat(dims?.length ?? 0)}`;
      this.names.push([name.toLowerCase(), path]);
      collect(inner, `${path}.`);
    });
    collect(this.own.members, '');
    return this.names;
  }

  /** Marks the members whose names have a text, in lower case, and lists them. */
  mark(wanted) {
    this.wanted = wanted;
    const hits = wanted === '' ? [] : this.members.filter(([name]) => name.includes(wanted)).map(([, path]) => path);
    this.hits.hidden = hits.length === 0;
    const more = hits.length > MAX_HITS ? `, and ${hits.length - MAX_HITS} more` : '';
    if (hits.length > 0) this.hits.replaceChildren('Has ', ...hits.slice(0, MAX_HITS).flatMap((path, at) => [at > 0 ? ', ' : '', el('mark', {}, path)]), more);
    if (!this.drawn) return;
    this.maps.querySelectorAll('.cell, .head').forEach((cell) => {
      const name = cell.place?.kind === 'padding' ? undefined : cell.place?.member?.name;
      cell.classList.toggle('hit', wanted !== '' && name !== undefined && name.toLowerCase().includes(wanted));
    });
  }

  figure(layout, several) {
    if (layout.size === null) {
      const rows = layout.members.map((member) => [member.name, member.type]);
      return table('Loose uniforms', ['Name', 'Type'], rows);
    }
    const name = `${this.title}, ${RULE_NAMES[layout.rules]}`;
    const map = memoryMap(layout, {
      view: this.view, state: this.state, label: `Memory map of ${name}; arrow keys move between cells`,
      changed: (byte) => {
        this.draw();
        this.focus(byte);
      },
    });
    const select = ({ target }) => {
      const { place } = target.closest('.cell, .head') ?? {};
      if (place) this.detail.show(place, layout, this.shader, this.view);
    };
    for (const event of ['mouseover', 'focusin', 'click']) map.addEventListener(event, select);
    const size = several ? bytes(layout.size) : sizeText(layout);
    const facts = [RULE_NAMES[layout.rules], size, comparison(layout, this.own)];
    const caption = several || layout !== this.own ? el('p', { class: 'caption' }, facts.filter(Boolean).join(' · ')) : null;
    const details = el('details', {}, el('summary', {}, `Table of ${name}`));
    details.fill = () => {
      details.fill = null;
      details.append(mapTable(map.items, `Members and padding of ${name}`, this.view !== null));
    };
    details.addEventListener('toggle', () => details.open && details.fill?.());
    return el('div', { class: 'figure', data: { rules: layout.rules } }, caption, map, details);
  }

  /** Answers who is at a byte, and shows it in the map. */
  find(given) {
    const trimmed = given.trim();
    this.element.querySelectorAll('.found').forEach((cell) => cell.classList.remove('found'));
    if (trimmed === '') {
      this.output.textContent = '';
      return;
    }
    if (!/^(\d{1,15}|0x[\da-f]{1,12})$/i.test(trimmed)) {
      this.output.textContent = 'A byte offset is a number such as 172 or 0xac.';
      return;
    }
    const byte = Number(trimmed);
    const shown = this.block.layouts.filter((layout) => this.rules.has(layout.rules));
    const answers = shown.map((layout) => {
      const rules = shown.length > 1 ? `${RULE_NAMES[layout.rules]}: ` : '';
      this.open(ownerOf(layout, byte, this.view?.byteLength));
      return rules + whoIsAt(layout, byte, this.view?.byteLength);
    });
    this.output.replaceChildren(...answers.map((answer) => el('p', {}, prose(answer))));
    this.draw();
    const found = this.cellsAt(byte);
    found.forEach((cell) => cell.classList.add('found'));
    found[0]?.scrollIntoView({ block: 'nearest' });
    if (found[0]) this.detail.show(found[0].place, shown[0], this.shader, this.view);
  }

  /** Opens the elements around a place. */
  open(found) {
    for (let at = found.place; at?.parent; at = at.parent) {
      const index = /\[(\d+)\]$/.exec(at.path);
      if (at.parent.kind !== 'array' || !index) continue;
      const opened = this.state.opened.get(at.parent.path) ?? new Set();
      this.state.opened.set(at.parent.path, opened.add(Number(index[1])));
    }
  }

  cellsAt(byte) {
    return [...this.element.querySelectorAll('.cell')].filter(({ place }) => byte >= place.start && byte < place.end);
  }

  focus(byte) {
    this.cellsAt(byte)[0]?.focus();
  }

  /** Reads a dropped or chosen file. */
  async read(file) {
    if (!file) return;
    const end = Math.min(file.size, 2 ** 28);
    this.dump = { name: file.name, size: file.size, buffer: await file.slice(0, end).arrayBuffer() };
    this.take();
  }

  /** Shows the bytes of the dump from the offset on. */
  take() {
    if (!this.dump) return;
    const { buffer, name } = this.dump;
    const given = this.offset.value.trim();
    const offset = /^(\d+|0x[\da-f]+)$/i.test(given) ? Number(given) : NaN;
    this.view = null;
    this.loaded.hidden = false;
    if (!(offset <= buffer.byteLength)) {
      this.odd.replaceChildren(el('p', {}, `${name} has ${bytes(buffer.byteLength)}, none from byte ${given}.`));
    } else {
      const remark = lengthRemark(this.own, buffer.byteLength - offset);
      if (remark?.refused) this.odd.replaceChildren(el('p', {}, `${name}: ${remark.what}.`));
      else this.view = new DataView(buffer, offset);
      this.remark = remark?.what;
    }
    this.draw();
  }

  forget(file) {
    Object.assign(this, { view: null, dump: null });
    file.value = '';
    this.loaded.hidden = true;
    this.odd.replaceChildren();
    this.draw();
  }

  /** Lists what is suspicious in the bytes. */
  report(shown) {
    const parts = [];
    for (const layout of shown) {
      const { list, more } = oddities(layout, this.view);
      const total = list.length + more;
      const under = shown.length > 1 ? ` under ${RULE_NAMES[layout.rules]}` : '';
      const title = total === 0 ? 'Nothing suspicious' : counted(total, 'suspicious value');
      parts.push(el('p', {}, `${this.dump.name}: ${title}${under}${this.remark ? `; ${this.remark}` : ''}.`));
      const rows = list.slice(0, 50).map(({ start, what }) => el('li', {}, el('button', {
        type: 'button', class: 'link', on: { click: () => this.goTo(layout, start) },
      }, prose(what))));
      if (rows.length > 0) parts.push(el('ul', {}, rows));
      if (total > rows.length) parts.push(el('p', {}, `and ${total - rows.length} more`));
    }
    this.odd.replaceChildren(...parts);
  }

  goTo(layout, byte) {
    this.open(ownerOf(layout, byte, this.view.byteLength));
    this.draw();
    this.focus(byte);
  }
}
