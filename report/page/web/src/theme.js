// Colours of light, dark and paper: the style sheet has them, charts read them from there.

const root = document.documentElement;
const key = 'stillframe-scheme';
const listeners = new Set();
const darkness = matchMedia('(prefers-color-scheme: dark)');
let paper = false;

function stored() {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;  // pages from files may have no storage
  }
}

let chosen = stored();

/** 'light' or 'dark': what the reader chose, else what the system prefers, and light on paper. */
export function scheme() {
  if (paper) return 'light';
  return chosen ?? (darkness.matches ? 'dark' : 'light');
}

function apply() {
  root.dataset.scheme = scheme();
  listeners.forEach((listener) => listener());
}

/** Calls listener whenever the colours have changed. */
export function onScheme(listener) {
  listeners.add(listener);
}

/** Makes a button switch between light and dark. */
export function schemeSwitch(button) {
  const label = () => {
    const next = scheme() === 'dark' ? 'light' : 'dark';
    button.textContent = next === 'dark' ? 'Dark' : 'Light';
    button.setAttribute('aria-label', `Switch to ${next} colours`);
  };
  button.addEventListener('click', () => {
    chosen = scheme() === 'dark' ? 'light' : 'dark';
    try {
      localStorage.setItem(key, chosen);
    } catch {
      // the choice then holds for this visit
    }
    apply();
  });
  onScheme(label);
  label();
}

/** Light colours while the page goes to paper. */
export function setPaper(on) {
  paper = on;
  apply();
}

/** The value of a colour of the style sheet, as in colour('--active'). */
export function colour(name) {
  return getComputedStyle(root).getPropertyValue(name).trim();
}

/** All colours that charts use, now. */
export function colours() {
  const names = ['text', 'muted', 'line', 'grid', 'surface', 'page', 'floor', 'passive', 'active', 'target',
    'good', 'bad', 'warn'];
  return Object.fromEntries(names.map((name) => [name, colour('--' + name)]));
}

darkness.addEventListener('change', apply);
root.dataset.scheme = scheme();
