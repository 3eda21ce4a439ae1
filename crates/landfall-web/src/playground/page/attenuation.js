// How a light falls off: its coefficients, a distance with the share of the light that is left there,
// and the curve.

const COEFFICIENTS = ['constant', 'linear', 'quadratic'];
/** The share of full scale below which light is not seen. */
const UNSEEN = 1 / 256;

/** The share of a light that is left at a distance. */
const shareAt = ({ constant = 1, linear: slope = 0, quadratic = 0 }, distance) => 1 / (constant + slope * distance + quadratic * distance * distance);

/** The distance at which a share of a light is left; `Infinity` where that much is left everywhere, 0 nowhere. */
function distanceOf({ constant = 1, linear: slope = 0, quadratic = 0 }, share) {
  const wanted = 1 / share - constant;
  if (wanted <= 0) return 0;
  if (quadratic <= 0) return slope > 0 ? wanted / slope : Infinity;
  return (-slope + Math.sqrt(slope * slope + 4 * quadratic * wanted)) / (2 * quadratic);
}

/** The distance from which on a light is not seen. */
function seenTo({ attenuation, intensity = 1, color, diffuse }) {
  const strength = intensity * Math.max(...triple(color ?? diffuse ?? 1));
  return distanceOf(attenuation, UNSEEN / strength);
}

/** How far a light with these coefficients is seen. */
function reaches(light) {
  const distance = seenTo(light);
  if (distance === 0) return 'below 1/256 of full scale everywhere';
  if (distance === Infinity) return 'is seen at every distance';
  return `below 1/256 of full scale from distance ${distance.toPrecision(3)} on`;
}

/** Where a light ends: at its range, if it would be seen farther, else where it is no longer seen. */
function ends(light) {
  if (!light?.position) return '';
  const seen = typeof light.attenuation === 'object' ? seenTo(light) : Infinity;
  const range = light.range ?? Infinity;
  const end = Number(Math.min(range, seen).toPrecision(3));
  if (end === Infinity) return '';
  return range <= seen ? `range ${end}` : `to ${end}`;
}

/** Changes the coefficients so that a share is left at a distance: those of distance by one factor. */
function fit(attenuation, distance, share) {
  const { constant = 1, linear: slope = 0, quadratic = 0 } = attenuation;
  const wanted = 1 / share - constant;
  if (wanted <= 0 || distance <= 0) return false;
  const now = slope * distance + quadratic * distance * distance;
  const digits = (value) => Number(value.toPrecision(4));
  if (now > 0) Object.assign(attenuation, { linear: digits((slope * wanted) / now), quadratic: digits((quadratic * wanted) / now) });
  else attenuation.quadratic = digits(wanted / (distance * distance));
  return true;
}

/** The controls of an attenuation; `changed` is called after each change. */
class AttenuationControls {
  constructor(tab, light, key) {
    Object.assign(this, { tab, light, sliders: [] });
    const { attenuation } = light;
    // What a person thinks in stays while a light is in hand.
    tab.distances.set(key, tab.distances.get(key) ?? this.firstDistance());
    const at = () => tab.distances.get(key);
    const add = (label, given) => this.sliders.push(tab.slider(label, { logarithmic: true, ...given }));
    for (const name of COEFFICIENTS.filter((one) => typeof attenuation[one] === 'number')) {
      add(name, { min: name === 'constant' ? 0.01 : 0.0001, max: 100, get: () => attenuation[name], set: (value) => {
        attenuation[name] = value;
        this.told();
      } });
    }
    add('at distance', { min: 0.01, max: 10000, get: at, set: (value) => {
      tab.distances.set(key, value);
      this.told();
    } });
    add('share left there', { min: 0.0001, max: 1, get: () => shareAt(attenuation, at()), set: (value) => {
      if (!fit(attenuation, at(), value)) tab.page.problem(`With constant ${attenuation.constant ?? 1}, no more than ${(1 / (attenuation.constant ?? 1)).toPrecision(3)} of the light is left anywhere.`);
      else tab.page.problem('');
      this.told();
    } });
    this.at = at;
    this.reach = el('p', { class: 'note' });
    this.curve = el('canvas', { class: 'curve', width: '600', height: '180', role: 'img' });
    this.elements = [...this.sliders.map(({ element }) => element), this.curve, this.reach];
    this.told();
  }

  /** The range of a light, or where it is no longer seen. */
  firstDistance() {
    const { light: { attenuation, range } } = this;
    const found = range ?? distanceOf(attenuation, 0.01);
    return Number.isFinite(found) && found > 0 ? Number(found.toPrecision(3)) : 10;
  }

  /** Shows what follows from the coefficients. */
  told() {
    this.sliders.forEach((slider) => slider.refresh());
    if (!this.reach) return;
    this.reach.textContent = reaches(this.light);
    this.draw();
  }

  /** Draws the share that is left over distance, with the distance in hand marked. */
  draw() {
    const { curve, light: { attenuation, range } } = this;
    const at = this.at();
    const end = 1.6 * Math.max(at, range ?? 0);
    const style = getComputedStyle(document.documentElement);
    const [text, line, accent] = ['--muted', '--line', '--accent'].map((name) => style.getPropertyValue(name));
    const context = curve.getContext('2d');
    const { width, height } = curve;
    const [left, bottom] = [10, height - 34];
    const x = (distance) => left + (distance / end) * (width - left - 10);
    const most = Math.max(shareAt(attenuation, 0), 1e-9);
    const y = (share) => bottom - (share / most) * (bottom - 10);
    context.clearRect(0, 0, width, height);
    context.lineWidth = 2;
    context.strokeStyle = line;
    context.strokeRect(left, 10, width - left - 10, bottom - 10);
    context.strokeStyle = accent;
    context.beginPath();
    for (let step = 0; step <= 200; step += 1) {
      const distance = (end * step) / 200;
      const share = range !== undefined && distance > range ? 0 : shareAt(attenuation, distance);
      if (step === 0) context.moveTo(x(distance), y(share));
      else context.lineTo(x(distance), y(share));
    }
    context.stroke();
    context.setLineDash([6, 6]);
    context.strokeStyle = text;
    context.beginPath();
    context.moveTo(x(at), 10);
    context.lineTo(x(at), bottom);
    context.stroke();
    context.setLineDash([]);
    context.fillStyle = text;
    context.font = '22px sans-serif';
    context.fillText('0', left, height - 8);
    const share = `${(100 * shareAt(attenuation, at)).toPrecision(2)} % at ${at}`;
    context.fillText(share, Math.min(x(at), width - context.measureText(share).width - 10), height - 8);
    curve.setAttribute('aria-label', `The light that is left over distance: ${share}`);
  }
}
