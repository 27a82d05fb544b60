// What is under a point of the picture: words, the ellipse of M on the surface, and the lobe.

const number = (x) => Number(x.toPrecision(5)).toString();
const degrees = (x) => `${x.toFixed(1)}°`;
const kEllipse = 0.07; // of the picture's height, where the surface is seen from the front

function rows(found) {
  const out = [['object', found.object], ['material', `${found.material} (${found.type})`],
    ['stretch', `${number(found.stretch.max)}, ${number(found.stretch.min)}`],
    ['gloss', found.follow ? 'follows' : 'held fixed']];
  if (found.gloss) {
    const g = found.gloss;
    out.push(['alpha', `${number(g.alpha_max)}, ${number(g.alpha_min)}`], ['turned by', degrees(g.alpha_rotation)],
      ['M', g.m.map(number).join(', ')], ['view', `${degrees(g.theta)} from the normal`]);
  }
  out.push(['plan', `M ${found.plan.stretch}, gradient ${found.plan.gradient}, interpolation ${found.plan.interpolation}`]);
  if (found.plan.multiscatter) out.push(['light of several facets', found.plan.multiscatter]);
  for (const q of found.plan.questions) {
    const why = q.choices.map((c) => `${c.name}: error ${number(c.predicted_error)}, ${number(c.cost)} ${q.unit}`).join('; ');
    out.push([q.name, `${q.taken} (${why})`]);
  }
  out.push(['distance', `${number(found.distance)} m`]);
  return out;
}

const kThin = { 'vector-effect': 'non-scaling-stroke' }; // lines as thick as on the screen

const svg = (name, attributes) => {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
};

function drawEllipse(overlay, at, size, found) {
  overlay.setAttribute('viewBox', `0 0 ${size.width} ${size.height}`);
  const marks = [svg('circle', { cx: at.x, cy: at.y, r: 0.005 * size.height, fill: '#fff', stroke: '#000', ...kThin })];
  const reach = kEllipse * size.height;
  if (found?.gloss) {
    const { major, minor } = found.gloss.ellipse;
    const points = [];
    for (let i = 0; i < 64; ++i) {
      const a = (i * Math.PI) / 32;
      points.push([0, 1].map((k) => (k ? at.y : at.x) + reach * (Math.cos(a) * major[k] + Math.sin(a) * minor[k])).map((v) => v.toFixed(2)));
    }
    for (const [color, width] of [['#000', 4], ['#fff', 2]])
      marks.push(svg('polygon', { points: points.join(' '), fill: 'none', stroke: color, 'stroke-width': width, ...kThin }));
  }
  if (found && found.stretch.max > 1.0005 * found.stretch.min) {
    const [x, y] = found.stretch.direction.map((v) => 1.4 * reach * v);
    for (const [color, width] of [['#000', 4], ['#ffd23d', 2]])
      marks.push(svg('line', { x1: at.x - x, y1: at.y - y, x2: at.x + x, y2: at.y + y, stroke: color, 'stroke-width': width, 'stroke-dasharray': '6 4', ...kThin }));
  }
  overlay.replaceChildren(...marks);
}

function drawLobe(canvas, lobe) {
  canvas.hidden = !lobe;
  if (!lobe) return;
  canvas.width = lobe.width;
  canvas.height = lobe.height;
  const context = canvas.getContext('2d');
  const image = context.createImageData(lobe.width, lobe.height);
  lobe.values.forEach((value, i) => {
    const grey = 255 * Math.max(0, value / Math.max(lobe.max, 1e-12)) ** (1 / 2.2);
    image.data.set([grey, grey, grey, 255], 4 * i);
  });
  context.putImageData(image, 0, 0);
  canvas.setAttribute('aria-label', `Lobe of the microsurface, greatest ${number(lobe.max)}; from the normal at the top to the other side, tangent at the left`);
}

export function showInspection({ words, overlay, lobe }, at, size, found) {
  drawEllipse(overlay, at, size, found);
  drawLobe(lobe, found?.gloss?.lobe);
  if (!found) {
    words.textContent = 'Nothing is there.';
    return;
  }
  const list = document.createElement('dl');
  for (const [key, value] of rows(found)) {
    const dt = document.createElement('dt');
    dt.textContent = key;
    const dd = document.createElement('dd');
    dd.textContent = value;
    list.append(dt, dd);
  }
  words.replaceChildren(list);
  if (!found.gloss) return;
  const code = document.createElement('code');
  code.textContent = found.gloss.probe;
  words.append(code);
}
