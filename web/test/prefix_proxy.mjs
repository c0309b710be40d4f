// A proxy that offers a page below a prefix, as nginx's `location /firn/ { proxy_pass http://up/; }` does.

import {createServer, request as ask} from "node:http";
import {connect} from "node:net";

export class PrefixProxy {
  /** @param upgrades false: WebSockets are not passed on, as by a proxy without its Upgrade header */
  constructor(up, prefix, {upgrades = true} = {}) {
    Object.assign(this, {up: new URL(up), prefix, upgrades, foreign: []});
  }

  async start() {
    this.http = createServer((request, response) => this.pass(request, response));
    if (this.upgrades) this.http.on("upgrade", (request, socket, head) => this.pass_socket(request, socket, head));
    await new Promise(resolve => this.http.listen(0, "127.0.0.1", resolve));
    return `http://127.0.0.1:${this.http.address().port}${this.prefix}`;
  }

  async end() {
    this.http.closeAllConnections();
    await new Promise(resolve => this.http.close(resolve));
  }

  path_of(request) {
    if (request.url.startsWith(this.prefix)) return "/" + request.url.slice(this.prefix.length);
    this.foreign.push(request.url);
    return null;
  }

  pass(request, response) {
    const path = this.path_of(request);
    if (path === null) return response.writeHead(404).end();
    const {connection: _, upgrade: __, ...rest} = request.headers;  // they go from one hop to the next only
    const headers = {...rest, host: this.up.host};
    const passed = ask({host: this.up.hostname, port: this.up.port, method: request.method, path, headers}, reply => {
      response.writeHead(reply.statusCode, reply.headers);
      reply.pipe(response);
    });
    passed.on("error", () => response.destroy());
    request.pipe(passed);
  }

  pass_socket(request, socket, head) {
    const path = this.path_of(request);
    if (path === null) return socket.destroy();
    const up = connect(this.up.port, this.up.hostname, () => {
      const headers = Object.entries({...request.headers, host: this.up.host}).map(([name, value]) => `${name}: ${value}\r\n`).join("");
      up.write(`GET ${path} HTTP/1.1\r\n${headers}\r\n`);
      up.write(head);
      socket.pipe(up).pipe(socket);
    });
    for (const one of [up, socket]) one.on("error", () => { up.destroy(); socket.destroy(); });
  }
}
