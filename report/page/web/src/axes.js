// Logarithmic axes as axes of log10, whose ticks are those a reader looks for.

const superscripts = {'-': '\u207b', 0: '\u2070', 1: '\u00b9', 2: '\u00b2', 3: '\u00b3', 4: '\u2074', 5: '\u2075',
  6: '\u2076', 7: '\u2077', 8: '\u2078', 9: '\u2079'};

/** 10 to the power of n, in print. */
export function powerOfTen(n) {
  return '10' + [...String(n)].map((digit) => superscripts[digit]).join('');
}

/** A number with so many significant digits, without an exponent where that is readable; '–' if there is none. */
export function number(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '\u2013';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) {
    const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
    return value.toFixed(Math.min(decimals, 12)).replace('-', '\u2212');
  }
  const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
  return `${mantissa.replace('-', '\u2212')}\u00b7${powerOfTen(Number(exponent))}`;
}

export const log10 = (value) => (value > 0 ? Math.log10(value) : null);
export const decibel = (value) => (value > 0 ? 20 * Math.log10(value) : null);

/** Smallest and largest of lists of numbers; null and other absent values are passed over. */
export function extent(...lists) {
  let lowest = Infinity, highest = -Infinity;
  for (const list of lists) {
    for (const value of list) {
      if (value === null || !Number.isFinite(value)) continue;
      if (value < lowest) lowest = value;
      if (value > highest) highest = value;
    }
  }
  return [lowest, highest];
}

/** Ticks between two powers of ten on so many pixels: 1, 2, 5, or each power, or each second, third ... power. */
function ticks(low, high, pixels) {
  const perDecade = pixels / (high - low);
  const steps = perDecade > 60 ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil(22 / perDecade));
  const values = [];
  for (let decade = Math.floor(low); decade <= Math.ceil(high); ++decade) {
    if (decade % every) continue;
    for (const step of steps) values.push(decade + Math.log10(step));
  }
  return values;
}

/** A label of a linear axis: as short as its ticks allow, with a typographic minus. */
export const plainLabel = (value) => String(Number(value.toPrecision(6))).replace('-', '\u2212');

const common = (c) => ({
  nameTextStyle: {color: c.muted, fontSize: 12},
  axisLine: {show: true, onZero: false, lineStyle: {color: c.line}},
  axisTick: {show: true, lineStyle: {color: c.line}, length: 4},
  axisLabel: {color: c.muted, fontSize: 12, hideOverlap: true, formatter: plainLabel},
  splitLine: {show: true, lineStyle: {color: c.grid, width: 1}},
  axisPointer: {label: {show: false}, lineStyle: {color: c.muted, type: 'solid', width: 1}},
});

/** A linear axis. */
export function linearAxis(c, options = {}) {
  const {axisLabel, axisTick, splitLine, axisPointer, ...rest} = options;
  const base = common(c);
  return {
    type: 'value', ...base,
    axisLabel: {...base.axisLabel, ...axisLabel},
    axisTick: {...base.axisTick, ...axisTick},
    splitLine: {...base.splitLine, ...splitLine},
    axisPointer: {...base.axisPointer, ...axisPointer},
    ...rest,
  };
}

/** An axis on so many pixels for data that are log10 of what is meant, from 10^low to 10^high. */
export function logAxis(c, low, high, pixels, options = {}) {
  const values = ticks(low, high, pixels);
  const plain = low >= -2 && high <= 5;
  return linearAxis(c, {
    min: low, max: high,
    ...options,
    axisTick: {customValues: values, ...options.axisTick},
    axisLabel: {
      customValues: values,
      formatter: (value) => (plain ? String(Number((10 ** value).toPrecision(2))) : powerOfTen(Math.round(value))),
      ...options.axisLabel,
    },
  });
}

/** A frequency axis on so many pixels between two frequencies in Hz. */
export function frequencyAxis(c, lowest, highest, pixels, options = {}) {
  return logAxis(c, Math.log10(lowest), Math.log10(highest), pixels,
    {name: 'Hz', nameLocation: 'middle', nameGap: 25, ...options});
}

/** Where the axes stand, in pixels, whatever their labels need. */
export function plotArea(place) {
  return {outerBoundsMode: 'none', ...place};
}

/** What every tooltip looks like. */
export function tooltip(c, options = {}) {
  return {
    confine: true,
    backgroundColor: c.surface,
    borderColor: c.line,
    borderWidth: 1,
    padding: [6, 10],
    textStyle: {color: c.text, fontSize: 12},
    extraCssText: 'box-shadow: 0 2px 10px rgb(0 0 0 / 18%); font-variant-numeric: tabular-nums;',
    ...options,
  };
}

const keys = {
  line: 'path://M0 3.4 H18 V5.6 H0 Z',
  dashes: 'path://M0 3.9 H5 V5.1 H0 Z M6.5 3.9 H11.5 V5.1 H6.5 Z M13 3.9 H18 V5.1 H13 Z',
};

/** Names with their keys: {name, key}, key line (if absent), dashes, circle or diamond; small on narrow charts. */
export function legend(c, entries, width) {
  const small = width < 280;
  return {
    top: 0, left: 0, padding: [5, 0], itemWidth: small ? 13 : 18, itemHeight: 9, itemGap: small ? 8 : 16,
    data: entries.map(({name, key = 'line'}) => ({name, icon: keys[key] ?? key})),
    textStyle: {color: c.text, fontSize: small ? 11 : 13}, inactiveColor: c.line,
  };
}

/** Text that came from a log, made safe for a tooltip. */
export function escape(text) {
  return String(text).replace(/[&<>"']/g, (character) => `&#${character.charCodeAt(0)};`);
}
