// The controls of the scene's own values, made from what the server says that it has.

const shown = (x) => (Math.abs(x) >= 100 ? x.toFixed(0) : Number(x.toPrecision(3)).toString());

function slider(entry, value, label, onInput) {
  const input = document.createElement('input');
  input.type = 'range';
  input.min = Math.min(entry.min, value);
  input.max = Math.max(entry.max, value);
  input.step = 'any';
  input.value = value;
  input.setAttribute('aria-label', label);
  const output = document.createElement('output');
  output.textContent = shown(value);
  input.setAttribute('aria-valuetext', shown(value));
  let next = value;
  input.addEventListener('input', () => {
    next = Number((Math.round(Number(input.value) / entry.step) * entry.step).toPrecision(12));
    output.textContent = shown(next);
    input.setAttribute('aria-valuetext', shown(next));
    onInput(next, false);
  });
  input.addEventListener('change', () => onInput(next, true));
  // Without a step of its own a slider's arrow keys move by one: here by the entry's.
  input.addEventListener('keydown', (event) => {
    const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (!sign || event.altKey) return;
    event.preventDefault();
    input.value = Number(input.value) + sign * entry.step * (event.shiftKey ? 10 : 1);
    input.dispatchEvent(new Event('input'));
    input.dispatchEvent(new Event('change'));
  });
  return [input, output];
}

function named(tag, text, className) {
  const element = document.createElement(tag);
  const span = document.createElement('span');
  span.textContent = text;
  element.append(span);
  if (className) element.className = className;
  return element;
}

function control(entry, isChanged, change) {
  const title = entry.label + (entry.keyed ? ', keyed' : '');
  const name = `${entry.group}, ${title}`;
  if (entry.kind === 'bool') {
    const label = named('label', title, `check${isChanged ? ' changed' : ''}`);
    const box = document.createElement('input');
    box.type = 'checkbox';
    box.checked = entry.value;
    box.addEventListener('change', () => change(entry, box.checked, true));
    label.append(box);
    return label;
  }
  if (entry.kind === 'choice') {
    const label = named('label', title, isChanged ? 'changed' : '');
    const select = document.createElement('select');
    for (const option of entry.names) select.add(new Option(option, option, false, option === entry.value));
    select.addEventListener('change', () => change(entry, select.value, true));
    label.append(select);
    return label;
  }
  if (entry.kind === 'number') {
    const label = named('label', title, isChanged ? 'changed' : '');
    const [input, output] = slider(entry, entry.value, name, (value, isLast) => change(entry, value, isLast));
    label.append(input, output);
    return label;
  }
  const set = document.createElement('fieldset');
  const legend = document.createElement('legend');
  legend.textContent = title;
  if (isChanged) legend.className = 'changed';
  set.append(legend);
  const values = [...entry.value];
  values.forEach((value, i) => {
    const label = document.createElement('label');
    const part = values.length === 3 ? 'xyz'[i] : values.length === 2 ? ['along', 'across'][i] : `${i + 1}`;
    const [input, output] = slider(entry, value, `${name}, ${part}`, (next, isLast) => {
      values[i] = next;
      change(entry, [...values], isLast);
    });
    label.append(input, output);
    set.append(label);
  });
  return set;
}

// `change(entry, value, isLast)` is called while a control moves, and once more when it rests.
export function buildPanel(home, state, change) {
  const active = document.activeElement?.getAttribute?.('aria-label');
  const closed = new Set([...home.querySelectorAll('details:not([open])')].map((d) => d.dataset.group));
  const changed = new Set(state.changes.map((c) => c.key));
  const groups = new Map();
  for (const entry of state.panel) {
    if (!groups.has(entry.group)) {
      const details = document.createElement('details');
      details.dataset.group = entry.group;
      details.open = !closed.has(entry.group);
      const summary = document.createElement('summary');
      summary.textContent = entry.group;
      details.append(summary);
      groups.set(entry.group, details);
    }
    groups.get(entry.group).append(control(entry, changed.has(entry.key), change));
  }
  home.replaceChildren(...groups.values());
  if (active) [...home.querySelectorAll('input')].find((input) => input.getAttribute('aria-label') === active)?.focus();
}
