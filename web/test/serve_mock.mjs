// A page to look at without a print: node test/serve_mock.mjs [PORT]; a layer every 3 s.

import {MockServer} from "./mock_server.mjs";

const server = new MockServer();
const address = await server.start(Number(process.argv[2] ?? 8737));
console.log(`${address}#token=${server.token}`);
setInterval(() => {
  if (server.live.live && !server.state.paused && server.live.printed < server.live.planned) server.next_layer();
}, 3000);
