// Addresses of this page's process, below the folder that the page came from: a proxy may offer it under a prefix.

/** "api/runs" as this page asks for it. */
export function address_of(path: string): string {
  return new URL(path, document.baseURI).href;
}

/** The same of a WebSocket. */
export function socket_address(path: string): string {
  return address_of(path).replace(/^http/, "ws");
}

/** Why no WebSocket opens, where the process or a proxy can say so; null: nobody answers. */
export async function refusal_of_socket(path: string): Promise<string | null> {
  // As a POST it has an Origin header, as the WebSocket had.
  const reply = await fetch(address_of(path), {method: "POST"}).catch(() => null);
  if (reply?.status === 403) return (await reply.json().catch(() => null))?.error ?? "the connection is refused";
  return reply ? "no live connection: a proxy in between must pass WebSockets (its Upgrade and Connection headers)" : null;
}
