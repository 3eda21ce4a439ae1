// Elements from names, attributes and texts. All text of shaders goes through `textContent`: none
// of it is ever parsed as HTML.

/**
 * A text of a shader without the characters that reorder or hide text: control characters as their
 * pictures, the others as U+FFFD, as the command prints them.
 */
const plain = (shown) => String(shown)
  .replace(/[\u0000-\u0008\u000b-\u001f]/g, (c) => String.fromCharCode(0x2400 + c.charCodeAt(0)))
  .replace(/[\u007f-\u009f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]/g, '\ufffd');

/** An element; children are elements or texts. */
function el(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === 'class') element.className = value;
    else if (key === 'on') Object.entries(value).forEach(([event, act]) => element.addEventListener(event, act));
    else if (key === 'data') Object.assign(element.dataset, value);
    else if (value !== null && value !== undefined && value !== false) {
      element.setAttribute(key, value === true ? '' : plain(value));
    }
  }
  for (const child of children.flat(3)) {
    if (child !== null && child !== undefined) element.append(child instanceof Node ? child : plain(child));
  }
  return element;
}

/** A path that breaks behind its separators before it does so within a name. */
const breakable = (path) => path.split(/(?<=[/\\_-])(?=.)/).flatMap((part, at) => (at > 0 ? [el('wbr'), part] : [part]));

/** A text in which `names` between backticks are code. */
function prose(message) {
  return String(message).split('`').map((part, index) => (index % 2 ? el('code', {}, part) : part));
}

/** A table with a caption; the first cell of a row heads it. */
function table(caption, columns, rows) {
  const head = el('tr', {}, columns.map((column) => el('th', { scope: 'col' }, column)));
  const body = rows.map((row) => el('tr', {}, row.map((cell, index) => (
    index === 0 ? el('th', { scope: 'row' }, cell) : el('td', {}, cell)
  ))));
  return el('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption },
    el('table', {}, el('caption', {}, caption), el('thead', {}, head), el('tbody', {}, body)));
}
