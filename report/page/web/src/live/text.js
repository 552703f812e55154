// Words and tables of the live page. Everything that came over the bus is set as text, never as HTML.
import {number} from '../axes.js';

function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
  return made;
}

/** Puts something in a place, unless what is there says the same already: a reader's selection then stays. */
export function fill(place, made) {
  if (place.innerHTML !== made.outerHTML) place.replaceChildren(made);
}

/** A table; the first nText columns are text. */
export function table(caption, header, rows, nText) {
  const made = element('table');
  made.append(element('caption', caption));
  const head = element('tr');
  header.forEach((text, i) => head.append(element('th', text, {scope: 'col', ...(i < nText ? {class: 'text'} : {})})));
  const thead = element('thead');
  thead.append(head);
  const body = element('tbody');
  rows.forEach((cells) => {
    const row = element('tr');
    cells.forEach((text, i) => row.append(i === 0 ? element('th', text, {scope: 'row'})
      : element('td', text, i < nText ? {class: 'text'} : {})));
    body.append(row);
  });
  made.append(thead, body);
  return made;
}

const clock = (seconds) => {
  const whole = Math.floor(seconds), minutes = Math.floor(whole / 60);
  return minutes ? `${minutes} min ${String(whole % 60).padStart(2, '0')} s` : `${whole} s`;
};

export function facts(place, {run}) {
  const list = !run ? [] : [
    ['run', run.run_id], ['loop', run.loop], ['mode', run.mode.replace('_', '-')],
    ['rate', run.sample_rate_hz ? `${number(run.sample_rate_hz, 4)} Hz` : ''],
    ['plant', run.state], ['time', run.seq < 0 ? '' : clock(run.time_s) + (run.duration_s ? ` of ${clock(run.duration_s)}` : '')],
  ].filter(([, value]) => value !== '' && value !== null);
  const made = list.map(([name, value]) => {
    const group = element('div');
    group.append(element('dt', name), element('dd', value));
    return group;
  });
  place.replaceChildren(...made);
}

const good = ['active', 'running'];

export function state(badge, {run, controller}) {
  const word = controller ? controller.text || controller.state : run?.state || (run ? 'measuring' : 'nothing heard');
  const kind = controller ? controller.state : word;
  badge.className = `badge ${good.includes(kind) ? 'pass' : kind === 'fault' || kind.startsWith('failed') ? 'fail' : ''}`;
  if (badge.textContent !== word) badge.textContent = word;
}

export function notes(place, list) {
  const made = list.map((text) => element('li', text, {class: 'warning'}));
  const same = made.length === place.children.length && made.every((item, i) => item.textContent === place.children[i].textContent);
  if (!same) place.replaceChildren(...made);
}
