// The divider between the editor and the results, which the pointer and the keyboard move.

/** The least and the most share of the editor, in percent. */
const SHARES = [15, 85];
/** Where the results stand below the editor. */
const BELOW = window.matchMedia('(max-width: 900px)');

/** What is divided: the width of the page, or, where it is narrow, the height of the window. */
const SIDES = [
  { name: 'editor-width', unit: '%', first: 42, orientation: 'vertical', of: 'width', keys: ['ArrowLeft', 'ArrowRight'] },
  { name: 'editor-height', unit: 'vh', first: 45, orientation: 'horizontal', of: 'height', keys: ['ArrowUp', 'ArrowDown'] },
];

class Divider {
  constructor(element) {
    Object.assign(this, { element, pane: element.parentElement });
    element.addEventListener('keydown', (event) => this.press(event));
    element.addEventListener('pointerdown', (event) => this.drag(event));
    element.addEventListener('dblclick', () => this.set(this.side.first));
    BELOW.addEventListener('change', () => this.told());
    for (const side of SIDES) this.put(side, Number(recalled('sessionStorage', side.name)) || side.first);
    this.told();
  }

  get side() { return SIDES[BELOW.matches ? 1 : 0]; }

  put(side, share) {
    side.share = Math.min(SHARES[1], Math.max(SHARES[0], share));
    this.pane.parentElement.style.setProperty(`--${side.name}`, `${side.share}${side.unit}`);
  }

  set(share) {
    const { side } = this;
    this.put(side, share);
    keep('sessionStorage', side.name, side.share);
    this.told();
  }

  /** Says where the divider is. */
  told() {
    const { share, orientation, of } = this.side;
    const now = Math.round(share);
    const facts = { orientation, valuemin: SHARES[0], valuemax: SHARES[1], valuenow: now, valuetext: `${now} % of the ${of}` };
    for (const [name, value] of Object.entries(facts)) this.element.setAttribute(`aria-${name}`, String(value));
  }

  press(event) {
    const { share, first, keys: [less, more] } = this.side;
    const to = { [less]: share - 2, [more]: share + 2, PageUp: share - 10, PageDown: share + 10, Home: SHARES[0], End: SHARES[1], Enter: first }[event.key];
    if (to === undefined || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    this.set(to);
  }

  drag(event) {
    if (event.button !== 0) return;
    const { element, pane } = this;
    // The text under the pointer is not selected; the divider still takes the focus.
    event.preventDefault();
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    const end = new AbortController();
    const box = pane.getBoundingClientRect();
    element.addEventListener('pointermove', ({ clientX, clientY }) => this.set(100 * (BELOW.matches
      ? (box.height + clientY - event.clientY) / window.innerHeight
      : (box.width + clientX - event.clientX) / pane.parentElement.clientWidth)), { signal: end.signal });
    for (const name of ['pointerup', 'pointercancel']) element.addEventListener(name, () => end.abort(), { signal: end.signal });
  }
}
