// Makes one entry point of src/ into one script that needs nothing beside it.
//   node build.mjs ENTRY OUT.js OUT.hash
// OUT.hash is the script's digest as a content security policy wants it, "sha256-...".
import {createHash} from 'node:crypto';
import {existsSync, readFileSync, readdirSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const [entry, script, hash] = process.argv.slice(2);

let esbuild;
try {
  esbuild = await import('esbuild');
} catch {
  console.error('report/page/web: its packages are not installed; run scripts/setup');
  process.exit(1);
}

const {metafile, outputFiles} = await esbuild.build({
  absWorkingDir: here,
  entryPoints: [join('src', entry)],
  outfile: script,
  bundle: true,
  minify: true,
  format: 'iife',
  target: ['es2022'],
  charset: 'ascii',  // whatever encoding the page is read in
  legalComments: 'inline',
  define: {'process.env.NODE_ENV': '"production"'},
  logLevel: 'warning',
  metafile: true,
  write: false,
});

// The licences of whatever went in, word for word: they ask to go wherever the code goes.
const packages = new Set(Object.keys(metafile.inputs)
  .map((path) => /^node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(path)?.[1]).filter(Boolean));
const licences = [...packages].sort().map((name) => {
  const folder = join(here, 'node_modules', name);
  const {version} = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  const texts = readdirSync(folder).filter((file) => /^(licen[cs]e|notice)(\.\w+)?$/i.test(file)).sort();
  if (!texts.length) throw new Error(`${name} has no licence file`);
  const extra = join(folder, 'licenses');
  const paths = [...texts.map((file) => join(folder, file)),
    ...(existsSync(extra) ? readdirSync(extra).sort().map((file) => join(extra, file)) : [])];
  return [`${name} ${version}`, ...paths.map((path) => readFileSync(path, 'utf8').trim())].join('\n\n');
});
const rule = '\n' + '-'.repeat(80) + '\n';
const banner = `/*!\nThis script contains:\n${rule}${licences.join(rule).replaceAll('*/', '* /')}\n*/\n`;
// A browser takes every line end for \n before it checks the digest.
const text = (banner + outputFiles[0].text).replace(/\r\n?/g, '\n');

// A script that stands in a page must not hold the tags that end or disguise one.
if (/<\/script|<!--/i.test(text)) {
  console.error(`report/page/web: ${entry} holds a tag that would end the script element`);
  process.exit(1);
}
writeFileSync(script, text);
writeFileSync(hash, 'sha256-' + createHash('sha256').update(text).digest('base64'));
