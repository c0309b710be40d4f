// The settings of the shown run.

import {html} from "htm/preact";
import {useState} from "preact/hooks";
import {use_observed} from "../data/observable";
import type {Session} from "../data/session";
import {changed, value_words} from "../data/settings";
import {unit_words} from "../data/words";

export function Settings({session}: {session: Session}) {
  use_observed(session);
  const [all, set_all] = useState(false);
  const [words, set_words] = useState("");
  const {settings} = session.hello.run;
  if (!settings?.length) return null;
  const rows = (all ? settings : changed(settings)).filter(one => one.key.includes(words.trim()));
  return html`
    <section class="panel" aria-labelledby="settings-title">
      <details>
        <summary><h2 id="settings-title">Settings</h2> <span class="soft">${changed(settings).length} of ${settings.length} differ from their default</span></summary>
        <div class="row">
          <label>Search <input type="search" value=${words} onInput=${(e: Event) => set_words((e.target as HTMLInputElement).value)} /></label>
          <label class="check"><input type="checkbox" checked=${all} onChange=${() => set_all(!all)} /> defaults too</label>
        </div>
        <div class="scroll" tabindex="0" role="region" aria-label="Table of settings"><table>
          <thead><tr><th scope="col">Key</th><th scope="col">Value</th><th scope="col">Default</th></tr></thead>
          <tbody>${rows.map(one => html`<tr key=${one.key}><td><code>${one.key}</code></td>
            <td>${value_words(one.value)} ${unit_words(one.unit ?? "")}</td><td class="soft">${one.default === undefined ? "–" : value_words(one.default)}</td></tr>`)}</tbody>
        </table></div>
      </details>
    </section>`;
}
