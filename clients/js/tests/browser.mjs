// Opens the example in Chromium, on a live service, and takes two pictures half a second apart.
// Usage: node browser.mjs CHROMIUM SERVICE FOLDER. Prints what the page logged, and how many requests left for elsewhere.
import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { chromium } from 'playwright-core';

const [executablePath, service, folder] = process.argv.slice(2);
const HERE = new URL('../', import.meta.url);
const TYPES = { js: 'text/javascript', html: 'text/html' };
const server = createServer(async ({ url }, answer) => {
  const { pathname } = new URL(url, 'http://localhost');
  const data = await readFile(new URL(`.${pathname}`, HERE)).catch(() => undefined);
  answer.writeHead(data ? 200 : 404, { 'content-type': TYPES[pathname.split('.').at(-1)] ?? 'text/plain' }).end(data);
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
const page_url = `http://127.0.0.1:${server.address().port}/example.html?service=${service}`;

const args = ['--no-sandbox', '--disable-background-networking', '--disable-component-update', '--disable-sync', '--no-first-run',
  '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const browser = await chromium.launch({ executablePath, args });
const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
const problems = [];
const elsewhere = [];
page.on('pageerror', (error) => problems.push(String(error)));
page.on('console', (message) => message.type() === 'error' && !/favicon/.test(message.location().url) && problems.push(message.text()));
page.on('request', (request) => request.url().startsWith('http://127.0.0.1:') || elsewhere.push(request.url()));
await page.goto(page_url);
await page.waitForSelector('canvas', { timeout: 30_000 });
await page.waitForTimeout(2000);
await page.screenshot({ path: `${folder}/first.png` });
await page.click('#wave');
await page.waitForTimeout(1500);
await page.screenshot({ path: `${folder}/second.png` });
console.log(JSON.stringify({ problems, elsewhere }));
await browser.close();
server.close();
