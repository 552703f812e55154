// Envelopes of signals as the page holds them: 16-bit codes in base64, value = origin + step * code.

const absent = -32768;

function codes(text) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Int16Array.from({length: bytes.length / 2}, (_, i) => view.getInt16(2 * i, true));
}

/** {first, part, lower, upper, smallest, largest}: times in s, values as numbers, NaN where there are none. */
export function decode(packed) {
  if (!packed) return null;
  const value = (code) => (code === absent ? NaN : packed.origin + packed.step * code);
  const lower = Float64Array.from(codes(packed.lower), value);
  const upper = packed.upper ? Float64Array.from(codes(packed.upper), value) : lower;
  return {first: packed.first_time_s, part: packed.part_s, lower, upper, smallest: packed.smallest,
    largest: packed.largest};
}

/** Smallest and largest value between two times. */
export function range(envelope, from, to) {
  const [first, last] = parts(envelope, from, to);
  let low = Infinity, high = -Infinity;
  for (let i = first; i < last; ++i) {
    if (envelope.lower[i] < low) low = envelope.lower[i];
    if (envelope.upper[i] > high) high = envelope.upper[i];
  }
  return [low, high];
}

function parts({first, part, lower}, from, to) {
  return [Math.max(0, Math.floor((from - first) / part) - 1), Math.min(lower.length, Math.ceil((to - first) / part) + 2)];
}

/** A line through the envelope between two times, of at most so many stretches: down and up in each of them. */
export function polyline(envelope, from, to, most) {
  const [first, last] = parts(envelope, from, to);
  const join = Math.max(1, Math.ceil((last - first) / most));
  const single = join === 1 && envelope.lower === envelope.upper;
  const line = [];
  // Stretches begin at multiples of their length, so that moving the view does not change their values.
  for (let i = first - (first % join); i < last; i += join) {
    let low = Infinity, high = -Infinity;
    const end = Math.min(i + join, envelope.lower.length);
    for (let j = i; j < end; ++j) {
      if (envelope.lower[j] < low) low = envelope.lower[j];
      if (envelope.upper[j] > high) high = envelope.upper[j];
    }
    const time = envelope.first + (i + (single ? 0 : join / 2)) * envelope.part;
    if (low > high) {
      line.push([time, null]);
    } else if (single) {
      line.push([time, low]);
    } else {
      line.push([time, low], [time, high]);
    }
  }
  return line;
}
