// Puts the built page where the Rust crate embeds it, after a look at what must hold for it.
import { readFileSync, writeFileSync } from "node:fs";

const html = readFileSync(new URL("../dist/index.html", import.meta.url), "utf8");
const count = (text) => html.split(text).length - 1;
if (count('"MENISCUS_DATA"') !== 1) throw new Error("the place for the data is not there exactly once");
if (/<(script|link|img)[^>]*\s(src|href)=(?!"data:)/.test(html)) throw new Error("the page asks for another file");
writeFileSync(new URL("../../crates/view/assets/page.html", import.meta.url), html);
console.log(`crates/view/assets/page.html: ${Math.round(html.length / 1000)} kB`);
