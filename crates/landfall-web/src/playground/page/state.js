// The state of the page in the fragment of its address: JSON, compressed by deflate, in base64url.

/** The most bytes of a state. */
const MAX_STATE = 4 * 2 ** 20;

const through = async (bytes, stream) => {
  const all = [];
  let length = 0;
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    length += value.length;
    if (length > MAX_STATE) throw new Error('the state in the address is too large');
    all.push(value);
  }
  return new Uint8Array(await new Blob(all).arrayBuffer());
};

async function packed(state) {
  const bytes = await through(new TextEncoder().encode(JSON.stringify(state)), new CompressionStream('deflate-raw'));
  let binary = '';
  for (let at = 0; at < bytes.length; at += 8192) binary += String.fromCharCode(...bytes.subarray(at, at + 8192));
  return btoa(binary).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
}

/** The state in a fragment; `null` where there is none. */
async function unpacked(fragment) {
  if (!fragment.startsWith('#s=')) return null;
  const found = /^#s=([\w-]+)$/.exec(fragment);
  if (!found) throw new Error('it has letters that no link has');
  const binary = atob(found[1].replaceAll('-', '+').replaceAll('_', '/'));
  const bytes = await through(Uint8Array.from(binary, (c) => c.charCodeAt(0)), new DecompressionStream('deflate-raw'));
  const state = JSON.parse(new TextDecoder().decode(bytes));
  const known = {};
  for (const [key, value] of Object.entries(state ?? {})) {
    if (typeof value === 'string' || typeof value === 'boolean') known[key] = value;
  }
  return known;
}

/** Pairs of texts as JSON in a state; none where it is anything else. */
function pairs(text) {
  try {
    const all = JSON.parse(text);
    return all.filter((pair) => Array.isArray(pair) && pair.length === 2 && pair.every((part) => typeof part === 'string'));
  } catch {
    return [];
  }
}

/** What a store of the browser holds, `localStorage` or, for the session, `sessionStorage`; browsers may refuse. */
function recalled(store, key) {
  try {
    return window[store].getItem(`landfall-${key}`);
  } catch {
    return null;
  }
}

/** Keeps a choice in a store of the browser, where it lets the page. */
function keep(store, key, value) {
  try {
    window[store].setItem(`landfall-${key}`, value);
  } catch {
    // The choice lasts as long as the page.
  }
}
