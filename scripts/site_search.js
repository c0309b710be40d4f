// The search of the documents' pages, in place of mkdocs' own: that one asks a server in a worker, and these pages are
// read as files, too. documents.js, beside it, sets firnDocuments: location, title and text of every section.
"use strict";
(() => {
  const results = document.getElementById("mkdocs-search-results");
  if (!results) return; // of all pages search.html alone shows results

  const load = (file) =>
    new Promise((loaded, failed) => {
      const script = document.createElement("script");
      Object.assign(script, { src: `${base_url}/search/${file}`, onload: loaded, onerror: failed });
      document.head.append(script);
    });

  const article = ({ location, title, text }) => {
    const link = Object.assign(document.createElement("a"), { href: `${base_url}/${location}`, textContent: title });
    const heading = document.createElement("h3");
    heading.append(link);
    const entry = document.createElement("article");
    entry.append(heading, Object.assign(document.createElement("p"), { textContent: text.slice(0, 200) }));
    return entry;
  };

  const answer = (words) => {
    const byLocation = new Map(firnDocuments.map((section) => [section.location, section]));
    const index = lunr(function () {
      this.ref("location");
      this.field("title", { boost: 10 });
      this.field("text");
      for (const section of firnDocuments) this.add(section);
    });
    // Each word must occur; the last one may be the beginning of a word.
    const found = index.query((query) => {
      for (const token of lunr.tokenizer(words)) {
        query.term(token, { presence: lunr.Query.presence.REQUIRED, wildcard: lunr.Query.wildcard.TRAILING });
      }
    });
    const nothing = Object.assign(document.createElement("p"), { textContent: `Nothing mentions ${words}.` });
    results.replaceChildren(...(found.length ? found.map(({ ref }) => article(byLocation.get(ref))) : [nothing]));
  };

  const words = new URLSearchParams(location.search).get("q") ?? "";
  document.getElementById("mkdocs-search-query").value = words;
  load("lunr.js").then(() => load("documents.js")).then(() => answer(words));
})();
