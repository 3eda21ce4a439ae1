// The state of the page in the fragment of its address: JSON, compressed by deflate, in base64url.

/** The most bytes of a state. */
const MOST_STATE = 4 * 2 ** 20;

const through = async (bytes, stream) => {
  const all = [];
  let length = 0;
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    length += value.length;
    if (length > MOST_STATE) throw new Error('the state in the address is too large');
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
