// Opens reports in headless Chromium as a reader would.
//   node test_report.mjs MAKE_SAMPLE_PAGE FOLDER
// MAKE_SAMPLE_PAGE writes the pages; screenshots and the paper version are left in FOLDER.
import {execFileSync} from 'node:child_process';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

import {allDrawn, check, exitCode, folder, withPage} from './browser.mjs';

const [makePage, out] = [process.argv[2], folder(process.argv[3])];
const page_of = (kind) => {
  const path = join(out, `${kind}.html`);
  execFileSync(makePage, [kind, path]);
  return pathToFileURL(path).href;
};
const sample = page_of('sample'), hostile = page_of('hostile'), empty = page_of('empty');

/** Colours of a canvas that occur in it, and a sum over its pixels. */
const readCanvas = (page, id) => page.evaluate((name) => {
  const canvas = document.getElementById(name);
  const copy = document.createElement('canvas');
  Object.assign(copy, {width: canvas.width, height: canvas.height});
  const context = copy.getContext('2d', {willReadFrequently: true});
  context.drawImage(canvas, 0, 0);
  const {data} = context.getImageData(0, 0, copy.width, copy.height);
  const colours = new Set();
  let sum = 0, filled = 0, atEdge = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] === 0) continue;
    ++filled;
    const x = i / 4 % copy.width, y = Math.floor(i / 4 / copy.width);
    if (Math.min(x, y, copy.width - 1 - x, copy.height - 1 - y) < 1) ++atEdge;
    colours.add((data[i] >> 4) << 8 | (data[i + 1] >> 4) << 4 | data[i + 2] >> 4);
    sum = (sum * 31 + data[i] + 7 * data[i + 1] + 13 * data[i + 2] + i) % 2147483647;
  }
  return {colours: colours.size, filled: filled / (data.length / 4), sum, atEdge};
}, id);

/** Length of all paths drawn inside the plot of a chart: a figure that is there has long ones. */
const inked = (page) => page.evaluate(() => Object.fromEntries([...document.querySelectorAll('.chart')].map((chart) =>
  [chart.id, [...chart.querySelectorAll('svg path')].reduce((sum, path) => sum + path.getTotalLength(), 0)])));

async function figuresAreThere(page) {
  const names = await page.evaluate(() => Object.keys(window.stillframe.figures));
  for (const name of ['fig-singular-values', 'fig-transmissibility-3', 'fig-fit-2', 'fig-mode-6', 'fig-history-3', 'fig-legs',
    'fig-octaves-1', 'fig-density-2', 'fig-cumulative-3', 'fig-histogram-2']) {
    check(names.includes(name), `${name} is among the figures`);
  }
  const places = await page.evaluate(() => [...document.querySelectorAll('.chart, .modes canvas')].map(({id}) => id));
  check(places.every((id) => names.includes(id)), 'every place for a figure has one');
  for (const [id, length] of Object.entries(await inked(page))) {
    check(length > 3000, `${id} has lines of ${Math.round(length)} px in all`);
  }
  // 6 curves of each family of the deck's figure, in the family's colour, longer than the picture is wide.
  const families = await page.evaluate(() => {
    const counts = {};
    for (const path of document.querySelectorAll('#fig-singular-values svg path')) {
      const colour = path.getAttribute('stroke');
      if (path.getAttribute('fill') === 'none' && path.getTotalLength() > 700) counts[colour] = (counts[colour] ?? 0) + 1;
    }
    return counts;
  });
  // Of 600 measured values one has no band and is not drawn, and one may be zero: its bar, and no other, goes down to
  // the bottom.
  const bars = await page.evaluate(() => {
    const chart = window.stillframe.charts().find((one) => one.getDom().id === 'fig-singular-values');
    const bottom = chart.convertToPixel({yAxisIndex: 0}, chart.getOption().yAxis[0].min);
    const counts = {bars: 0, toBottom: 0, points: 0};
    for (const {type, yAxisIndex, data} of chart.getOption().series) {
      if (type === 'scatter' && !yAxisIndex) counts.points += data.filter(([, y]) => y !== null).length;
    }
    for (const path of chart.getDom().querySelectorAll('svg path')) {
      const line = /^M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)$/.exec(path.getAttribute('d'))?.slice(1).map(Number);
      if (!line || path.getAttribute('stroke-width') !== '1.2' || line[0] !== line[2]) continue;
      ++counts.bars;
      if (Math.abs(Math.max(line[1], line[3]) - bottom) < 1) ++counts.toBottom;
    }
    return counts;
  });
  check(bars.points === 599 && bars.bars === 599 && bars.toBottom === 1, `bars of points: ${JSON.stringify(bars)}`);
  check(families['#d55e00'] === 6, `six open curves, not ${families['#d55e00']}`);
  check(families['#0072b2'] === 12, `six closed and six continuous curves, not ${families['#0072b2']}`);
  const pictures = new Set();
  for (let i = 1; i <= 6; ++i) {
    const {colours, filled, sum, atEdge} = await readCanvas(page, `fig-mode-${i}`);
    pictures.add(sum);
    check(atEdge === 0, `mode ${i} stays in its picture (${atEdge} pixels of its edge are drawn on)`);
    check(colours > 5 && filled > 0.05, `mode ${i} is drawn (${colours} colours, ${(100 * filled).toFixed(1)} %)`);
  }
  check(pictures.size === 6, 'no mode looks like another');
}

/** No word of a figure lies on another or runs into it, and no name stands among the curves of a density. */
async function wordsApart(page) {
  const pairs = await page.evaluate(() => [...document.querySelectorAll('.chart')].flatMap(({id}) => {
    const words = [...document.querySelectorAll(`#${id} svg text`)].filter((text) => text.textContent.trim())
      .map((text) => ({text: text.textContent, box: text.getBoundingClientRect()}));
    // Boxes hold a pixel or two above and below what is printed.
    const apart = (a, b) => a.right <= b.left - 3 || b.right <= a.left - 3 || a.bottom <= b.top + 3 || b.bottom <= a.top + 3;
    return words.flatMap((a, i) => words.slice(i + 1).filter((b) => !apart(a.box, b.box))
      .map((b) => `${id}: "${a.text}" lies on "${b.text}"`));
  }));
  for (const pair of pairs) check(false, pair);
  const names = await page.locator('#fig-density-1 svg text').allTextContents();
  check(!names.some((name) => /N[LH]NM/.test(name)), 'noise models are named above the densities, not among them');
}

async function accessible(page) {
  const faults = await page.evaluate(() => {
    const list = [];
    const levels = [...document.querySelectorAll('h1, h2, h3')].map((h) => Number(h.tagName[1]));
    levels.forEach((level, i) => { if (i && level > levels[i - 1] + 1) list.push(`heading ${i} skips a level`); });
    if (levels.filter((level) => level === 1).length !== 1) list.push('not one h1');
    for (const image of document.querySelectorAll('[role=img]')) {
      if (!image.getAttribute('aria-label')) list.push(`${image.id} has no words`);
    }
    for (const button of document.querySelectorAll('button')) {
      if (!(button.textContent || button.getAttribute('aria-label'))) list.push('a button without a name');
    }
    for (const cell of document.querySelectorAll('th')) if (!cell.scope) list.push('a header cell without a scope');
    const ids = [...document.querySelectorAll('[id]')].map(({id}) => id);
    if (new Set(ids).size !== ids.length) list.push('an id occurs twice');
    return list;
  });
  for (const fault of faults) check(false, fault);
  check(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'nothing is wider than the window');
}

/** Contrast of text with its ground, both schemes: 4.5 as WCAG 2 asks for. */
async function contrast(page, scheme) {
  const ratios = await page.evaluate(() => {
    const style = getComputedStyle(document.documentElement);
    const luminance = (name) => {
      const value = parseInt(style.getPropertyValue(name).trim().slice(1), 16);
      const part = (shift) => {
        const x = (value >> shift & 255) / 255;
        return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
      };
      return 0.2126 * part(16) + 0.7152 * part(8) + 0.0722 * part(0);
    };
    const pairs = [['--text', '--page'], ['--text', '--surface'], ['--muted', '--page'], ['--muted', '--surface'],
      ['--good', '--good-back'], ['--bad', '--bad-back'], ['--text', '--warn-back'], ['--active', '--page']];
    return pairs.map(([a, b]) => {
      const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
      return [`${a} on ${b}`, (high + 0.05) / (low + 0.05)];
    });
  });
  for (const [pair, ratio] of ratios) check(ratio >= 4.5, `${scheme}: contrast of ${pair} is ${ratio.toFixed(2)}`);
}

const view = (page) => page.evaluate(() => window.stillframe.timeView());
const settle = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
const linesOf = (page, id) => page.evaluate((name) =>
  [...document.querySelectorAll(`#${name} svg path`)].map((path) => path.getAttribute('d')).join(), id);

async function zoom(page) {
  const whole = await view(page);
  check(Math.abs(whole[0]) < 1e-9 && Math.abs(whole[1] - 60) < 0.1, `the whole run is seen: ${whole}`);
  const before = {first: await linesOf(page, 'fig-history-1'), legs: await linesOf(page, 'fig-legs')};
  await page.locator('#history-tools [data-zoom=in]').click();
  await settle(page);
  const half = await view(page);
  check(Math.abs(half[1] - half[0] - (whole[1] - whole[0]) / 2) < 1e-6, `a click halves the view: ${half}`);
  check(await linesOf(page, 'fig-history-1') !== before.first, 'the history follows');
  check(await linesOf(page, 'fig-legs') !== before.legs, 'the forces follow');

  const chart = page.locator('#fig-history-2');
  await chart.scrollIntoViewIfNeeded();
  const box = await chart.boundingBox();
  const middle = {x: box.x + box.width / 2, y: box.y + 80};
  await page.mouse.move(middle.x, middle.y);
  await page.keyboard.down('Control');
  await page.mouse.wheel(0, -200);
  await page.keyboard.up('Control');
  await settle(page);
  const wheeled = await view(page);
  check(wheeled[1] - wheeled[0] < 0.6 * (half[1] - half[0]), `Ctrl and wheel zoom: ${wheeled}`);
  await page.mouse.down();
  await page.mouse.move(middle.x + 100, middle.y, {steps: 5});
  await page.mouse.up();
  await settle(page);
  const moved = await view(page);
  check(moved[0] < wheeled[0] && Math.abs(moved[1] - moved[0] - (wheeled[1] - wheeled[0])) < 1e-6,
    `dragging to the right moves back in time: ${moved}`);
  const scroll = await page.evaluate(() => scrollY);
  await page.mouse.wheel(0, 300);
  await settle(page);
  await page.waitForTimeout(200);  // scrolling is smooth
  check(await page.evaluate(() => scrollY) > scroll, 'a wheel without Ctrl scrolls the page');
  check(String(await view(page)) === String(moved), 'and does not zoom');
  await page.locator('#history-tools [data-zoom=all]').focus();
  await page.keyboard.press('Enter');
  await settle(page);
  check(String(await view(page)) === String(whole), 'the keyboard brings the whole run back');
  check(await linesOf(page, 'fig-history-1') === before.first, 'and the picture it had');
}

async function tooltips(page) {
  const chart = page.locator('#fig-singular-values');
  await chart.scrollIntoViewIfNeeded();
  const box = await chart.boundingBox();
  await page.mouse.move(box.x + 400, box.y + 200);
  await page.mouse.move(box.x + 410, box.y + 205);
  await page.waitForTimeout(300);
  const text = await chart.innerText();
  check(/Hz/.test(text) && /open, predicted/.test(text), `pointing at the figure tells its values: ${text.slice(0, 80)}`);
}

async function switchScheme(page) {
  const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const ground = await back();
  await page.locator('#scheme').focus();
  await page.keyboard.press('Enter');
  check(await back() !== ground, 'the switch changes the colours');
  check((await page.locator('#scheme').getAttribute('aria-label')).includes('light'), 'and its own words');
  check((await page.evaluate(() => document.querySelector('#fig-singular-values').innerHTML)).includes('#ff8f45'),
    'charts take the dark colours');
  await page.reload();
  await allDrawn(page);
  check(await back() !== ground, 'the choice is remembered');
  await page.locator('#scheme').click();
  check(await back() === ground, 'a second press goes back');
}

async function animation(page) {
  await page.locator('#fig-mode-1').scrollIntoViewIfNeeded();
  const play = page.locator('#modes-play');
  check(await play.innerText() === 'Pause', 'pictures move from the start');
  const changes = async () => {
    const {sum} = await readCanvas(page, 'fig-mode-1');
    for (let i = 0; i < 20; ++i) {
      await page.waitForTimeout(100);
      if ((await readCanvas(page, 'fig-mode-1')).sum !== sum) return true;
    }
    return false;
  };
  check(await changes(), 'two frames differ');
  await play.click();
  await settle(page);
  check(!await changes(), 'paused pictures stand still');
  const {sum} = await readCanvas(page, 'fig-mode-4');
  await page.locator('#fig-mode-1').focus();
  await page.keyboard.press('ArrowLeft');
  check((await readCanvas(page, 'fig-mode-4')).sum !== sum, 'an arrow key turns all of them');
  await page.locator('#modes-view').click();
  check((await readCanvas(page, 'fig-mode-4')).sum === sum, 'the view can be reset');
  const box = await page.locator('#fig-mode-2').boundingBox();
  await page.mouse.move(box.x + 100, box.y + 100);
  await page.mouse.down();
  await page.mouse.move(box.x + 160, box.y + 120, {steps: 4});
  await page.mouse.up();
  check((await readCanvas(page, 'fig-mode-4')).sum !== sum, 'dragging turns them');
  await page.locator('#modes-view').click();
  // They stand from here on: without a graphics card moving pictures take most of the processor, and all that is
  // looked at after them waits for it.
}

async function paper(page, name) {
  const pdf = await page.pdf({path: join(out, `${name}.pdf`), preferCSSPageSize: true, printBackground: true});
  check(pdf.length > 100000, `the paper version has ${pdf.length} bytes`);
}

/** What the page is like while it goes to paper, seen from a listener that runs after the page's own. */
async function paperIsLight(page) {
  await page.evaluate(() => {
    addEventListener('beforeprint', () => {
      const mode = document.getElementById('fig-mode-1');
      window.onPaper = {
        ground: getComputedStyle(document.documentElement).getPropertyValue('--surface').trim(),
        charts: [...document.querySelectorAll('.chart svg')].map((svg) => Number(svg.getAttribute('width'))),
        open: [...document.querySelectorAll('details')].every((details) => details.open),
        mode: mode.width,
      };
    });
  });
  await page.pdf();
  const seen = await page.evaluate(() => window.onPaper);
  check(seen.ground === '#ffffff', `paper is white, not ${seen.ground}`);
  check(seen.charts.every((width) => width <= 690), `charts fit the paper: ${Math.max(...seen.charts)} px`);
  check(seen.open, 'all parts are open on paper');
  check(seen.mode === 560, 'mode shapes are fine on paper');
  await settle(page);
  check(await page.evaluate(() => [...document.querySelectorAll('.chart svg')].some((svg) => Number(svg.getAttribute('width')) > 700)),
    'charts are wide again after printing');
}

async function shot(page, name) {
  await page.evaluate(() => scrollTo(0, 0));
  await page.screenshot({path: join(out, `${name}.png`), fullPage: true});
}

for (const webgl of [true, false]) {
  const how = webgl ? 'WebGL' : 'no WebGL';
  await withPage(sample, {webgl, colorScheme: 'light'}, async (page) => {
    console.log(`light, ${how}: every figure drawn ${Math.round(await allDrawn(page))} ms after navigation`);
    check(await page.evaluate(() => window.stillframe.modeRenderer) === (webgl ? 'webgl' : 'canvas'),
      `mode shapes are drawn with ${how}`);
    await figuresAreThere(page);
    await animation(page);
    await shot(page, webgl ? 'light' : 'light_without_webgl');
    await paper(page, webgl ? 'paper' : 'paper_without_webgl');
    if (!webgl) return;
    await accessible(page);
    await wordsApart(page);
    await contrast(page, 'light');
    await tooltips(page);
    await zoom(page);
    await switchScheme(page);
  });
}

await withPage(sample, {webgl: true, colorScheme: 'dark'}, async (page) => {
  console.log(`dark: every figure drawn ${Math.round(await allDrawn(page))} ms after navigation`);
  await contrast(page, 'dark');
  await shot(page, 'dark');
  await paperIsLight(page);
});

await withPage(sample, {colorScheme: 'light', viewport: {width: 390, height: 800}}, async (page) => {
  await allDrawn(page);
  await accessible(page);
  await shot(page, 'narrow');
});

await withPage(sample, {colorScheme: 'light', reducedMotion: 'reduce'}, async (page) => {
  await allDrawn(page);
  check(await page.locator('#modes-play').innerText() === 'Play', 'reduced motion: pictures stand still from the start');
  await page.locator('#fig-mode-1').scrollIntoViewIfNeeded();
  const {sum} = await readCanvas(page, 'fig-mode-1');
  await page.waitForTimeout(700);
  check((await readCanvas(page, 'fig-mode-1')).sum === sum, 'reduced motion: and go on doing so');
});

await withPage(hostile, {colorScheme: 'light'}, async (page) => {
  await allDrawn(page);
  for (const id of ['fig-singular-values', 'fig-history-1', 'fig-legs', 'fig-octaves-1', 'fig-histogram-1']) {
    await page.locator(`#${id}`).hover();  // tooltips hold names as well
    await page.waitForTimeout(200);
    if (id !== 'fig-legs') continue;
    check((await page.locator(`#${id}`).innerText()).includes('</script>'), 'a tooltip tells a hostile name as it is');
  }
  check(await page.evaluate(() => window.broken === undefined), 'hostile names run no script');
  check(await page.evaluate(() => document.querySelectorAll('img').length === 0), 'hostile names make no element');
});

await withPage(empty, {colorScheme: 'light'}, async (page) => {
  check(await page.evaluate(() => document.querySelectorAll('h2, section').length === 0), 'an empty page has no parts');
});

console.log(`screenshots are in ${out}`);
process.exit(exitCode());
