// The dialog that asks for the token, once a tab.

import {html} from "htm/preact";
import {useEffect, useRef, useState} from "preact/hooks";
import {Observable, use_observed} from "../data/observable";
import {is_known, keep, set_asker, token} from "../data/token";

class Question extends Observable {
  purpose = "";
  answered: ((given: boolean) => void) | null = null;
}

const question = new Question();

/** True once there is a token; false where the reader gave none. */
export function have_token(purpose: string): Promise<boolean> {
  if (token() || is_known()) return Promise.resolve(true);
  question.answered?.(false);
  question.purpose = purpose;
  return new Promise(resolve => {
    question.answered = resolve;
    question.changed();
  });
}

set_asker(have_token);

export function TokenDialog() {
  use_observed(question);
  const dialog = useRef<HTMLDialogElement>(null);
  const [text, set_text] = useState("");
  const open = question.answered !== null;
  useEffect(() => {
    if (open && !dialog.current!.open) dialog.current!.showModal();
    if (!open && dialog.current!.open) dialog.current!.close();
  }, [open]);
  const answer = (given: boolean) => {
    if (given) keep(text);
    set_text("");
    const answered = question.answered;
    question.answered = null;
    question.changed();
    answered?.(given);
  };
  const submit = (event: Event) => {
    event.preventDefault();
    if (text.trim()) answer(true);
  };
  return html`
    <dialog ref=${dialog} aria-labelledby="token-title" onCancel=${(e: Event) => { e.preventDefault(); answer(false); }}>
      <form onSubmit=${submit}>
        <h2 id="token-title">Token</h2>
        <p>${question.purpose} needs the token that the terminal printed beside this page's address.</p>
        <label>Token
          <input type="password" autocomplete="off" autofocus value=${text}
            onInput=${(e: Event) => set_text((e.target as HTMLInputElement).value)} />
        </label>
        <p class="soft">This tab keeps it until it is closed.</p>
        <div class="row end">
          <button type="button" onClick=${() => answer(false)}>Cancel</button>
          <button type="submit" class="main" disabled=${!text.trim()}>Go on</button>
        </div>
      </form>
    </dialog>`;
}
