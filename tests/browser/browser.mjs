// What the browser tests share: a headless Chromium, and checks that collect what failed.
import {existsSync, mkdirSync, mkdtempSync, rmSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '../../report/page/web/package.json');
const candidates = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];

/** Ends the program in a way that ctest reports as skipped. */
function skip(reason) {
  console.log(`SKIPPED: ${reason}`);
  process.exit(0);
}

export const program = candidates.find((path) => path && existsSync(path));
if (!program) skip('no Chromium here (apt-get install chromium, or set CHROMIUM)');

let playwright;
try {
  playwright = createRequire(web)('playwright-core');
} catch {
  skip('playwright-core is not installed; run scripts/setup');
}

const plain = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--no-default-browser-check', '--disable-default-apps'];
const graphics = {
  webgl: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader'],  // WebGL without a graphics card
  none: ['--disable-3d-apis'],
};

let failures = 0;
export function check(holds, what) {
  if (holds) return;
  ++failures;
  console.log(`FAILED: ${what}`);
}

/** Whether all checks held, as an exit code. */
export const exitCode = () => (failures ? 1 : 0);

// A software driver remarks that reading a picture back is slow; graphics cards do not read back.
const driverRemark = /GL Driver Message .*GPU stall due to ReadPixels/;

/**
 * Opens a page with a profile of its own, runs test(page, problems) and closes everything. Problems are console messages
 * that are warnings or errors, exceptions, and requests for anything but the page: none may occur.
 */
export async function withPage(url, {webgl = false, ...options}, test) {
  const profile = mkdtempSync(join(tmpdir(), 'stillframe-browser-'));
  const context = await playwright.chromium.launchPersistentContext(profile, {
    executablePath: program, headless: true, args: [...plain, ...graphics[webgl ? 'webgl' : 'none']],
    viewport: {width: 1200, height: 900}, ...options,
  });
  const problems = [];
  try {
    const page = await context.newPage();
    page.on('console', (message) => {
      if (['warning', 'error'].includes(message.type()) && !driverRemark.test(message.text())) {
        problems.push(`console ${message.type()}: ${message.text()}`);
      }
    });
    page.on('pageerror', (error) => problems.push(`exception: ${error.stack}`));
    page.on('request', (request) => {
      if (request.url() !== url && !request.url().startsWith('data:')) problems.push(`request: ${request.url()}`);
    });
    await page.goto(url);
    await test(page, problems);
  } finally {
    await context.close();
    rmSync(profile, {recursive: true, force: true});
  }
  for (const problem of problems) check(false, problem);
}

/** Waits until every figure has reported that it has been drawn; answers the time since navigation, ms. */
export async function allDrawn(page) {
  await page.waitForFunction(() => {
    const figures = Object.values(window.stillframe?.figures ?? {});
    return figures.length && figures.every(Boolean);
  }, null, {timeout: 60000});
  return page.evaluate(() => window.stillframe.drawnAfterMs);
}

/** A folder for what is made here. */
export function folder(path) {
  mkdirSync(path, {recursive: true});
  return path;
}
